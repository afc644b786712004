"""Coulomb friction: a torque that opposes motion whatever its speed; none at rest, as sign(0) = 0."""

from __future__ import annotations

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.dynamics.effects.viscous_friction import joints_with_friction
from robodyn.programs.vectors import Scalar, exp, sign, sqrt, total
from robodyn.robot.kinematics import Motion
from robodyn.robot.model import Model
from robodyn.scene.parts import Friction
from robodyn.scene.scene import Scene


def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
    dry = [joint for _, joint, friction in joints_with_friction(model, scene) if friction.dry]
    none, some = "no joint has Coulomb friction", "joints with Coulomb friction"
    return Verdict.of_joints(dry, ("qd", zero_columns), none, "no joint with Coulomb friction moves", some)


def direction(qd: Scalar, slip_speed: float = 0.0) -> Scalar:
    """sign(qd), or `qd / sqrt(qd^2 + slip_speed^2)`."""
    square = slip_speed * slip_speed
    return qd / sqrt(qd * qd + square) if square else sign(qd)


def torque(friction: Friction, qd: Scalar, slip_speed: float = 0.0) -> Scalar:
    """`forward` for qd > 0, `backward` for qd < 0, 0 at rest; with Stribeck's excess towards `stribeck` at low speed.

    With s = sign(qd): `(forward - backward) / 2 s + (forward + backward) / 2 s^2`, and
    `(stribeck - Coulomb) exp(-(qd / v_s)^2)` with the same sign.

    Args:
        qd: the joint's speed [rad/s].
        slip_speed: if not 0, s is `qd / sqrt(qd^2 + slip_speed^2)`, which leaves rest without a jump [rad/s].

    Returns:
        N m, along the motion: what the actuator must supply.
    """
    s = direction(qd, slip_speed)
    coulomb = (0.5 * (friction.forward - friction.backward)) * s + (0.5 * (friction.forward + friction.backward)) * (
        s * s
    )
    if friction.stribeck is None:
        return coulomb
    ratio = qd / friction.stribeck_velocity
    return coulomb + (friction.stribeck * s - coulomb) * exp(-(ratio * ratio))


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    return terms.with_torques(
        (i, torque(friction, sample.speed(joint), scene.slip_speed))
        for i, joint, friction in joints_with_friction(sample.model, scene)
    )


def lost(sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
    """sum of torque times speed [W]."""
    moving = ((friction, sample.speed(joint)) for _, joint, friction in joints_with_friction(sample.model, scene))
    return total(torque(friction, speed, scene.slip_speed) * speed for friction, speed in moving)


EFFECT = Effect(
    "coulomb friction",
    "f sign(qd), sign(0) = 0; different forwards and backwards, and Stribeck's excess, if given",
    why,
    add,
    lost=lost,
)
