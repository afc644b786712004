"""Coupled motors: a motor that turns with a sum of joints, with its own rotor and friction, as in many wrists.

Its joint-side speed is `s = sum c_k qd_k`, and it needs `T = G^2 J sdd + d s + friction(s)`. Virtual work gives joint j
its part `c_j T`, so that the rotor adds `c c^T G^2 J` to the mass matrix.
"""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.dynamics.effects import coulomb_friction
from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.dynamics.effects.rotor_inertia import armatures
from robodyn.programs.vectors import Scalar, total
from robodyn.robot.kinematics import Motion
from robodyn.robot.model import Joint, Model
from robodyn.scene.parts import CoupledMotor
from robodyn.scene.scene import Scene

Entries = dict[tuple[int, int], float]
"""Of a symmetric matrix, by (i, j) with i <= j; those left out are zero."""
Turned = tuple[int, Joint, float]
"""A body, its joint, and how much a motor turns per turn of it, its gear aside."""


def coupled_motors(model: Model, scene: Scene) -> Iterator[tuple[CoupledMotor, list[Turned]]]:
    """Yield every coupled motor with the joints that it turns with."""
    for motor in scene.coupled:
        turned = [
            (i, body.joint, motor.joints[body.joint.name])
            for i, body in enumerate(model.bodies)
            if body.joint.name in motor.joints
        ]
        yield motor, turned


def reflected(model: Model, scene: Scene) -> Entries:
    """By coordinates, what rotors add to M: multiplier^2 G^2 J of single joints, c c^T G^2 J of coupled [kg m^2]."""
    entries: Entries = {}
    for _, joint, inertia in armatures(model, scene):
        _add(entries, joint.rate, joint.rate, joint.multiplier**2 * inertia)
    for motor, turned in coupled_motors(model, scene):
        shares = along(turned)
        for i, first in shares.items():
            for j, second in shares.items():
                if i <= j and motor.reflected:
                    _add(entries, i, j, first * second * motor.reflected)
    return entries


def along(turned: list[Turned]) -> dict[int, float]:
    """Return by coordinate how much a motor turns per rate of it, its gear aside."""
    shares: dict[int, float] = {}
    for _, joint, share in turned:
        shares[joint.rate] = shares.get(joint.rate, 0.0) + joint.multiplier * share
    return shares


def _add(entries: Entries, i: int, j: int, value: float) -> None:
    entries[i, j] = entries.get((i, j), 0.0) + value


def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
    acting = [each for each in coupled_motors(model, scene) if each[0].acts]
    joints = [joint for _, turned in acting for _, joint, _ in turned]
    still = all((source, joint.rate) in zero_columns for joint in joints for source in ("qd", "qdd"))
    names = ", ".join(motor.name for motor, _ in acting)
    none = "no joint of a coupled motor moves" if acting else "the scene has no coupled motor"
    return Verdict.of(acting and not still, none, f"motors of several joints: {names}")


def _rate(rates: tuple[Scalar, ...], turned: list[Turned]) -> Scalar:
    return total(share * (joint.multiplier * rates[joint.rate]) for _, joint, share in turned)


def torque(motor: CoupledMotor, speed: Scalar, acceleration: Scalar, slip_speed: float) -> Scalar:
    """`G^2 J sdd + d s + friction(s)` [N m]."""
    friction = motor.friction.viscous * speed + coulomb_friction.torque(motor.friction, speed, slip_speed)
    return friction + motor.reflected * acceleration


def torques(turned: list[Turned], torque: Scalar) -> Iterator[tuple[int, Scalar]]:
    """Yield (body, c_j torque), what a motor's torque is at the joint of each body."""
    return ((i, share * torque) for i, _, share in turned)


def speed_of(sample: Sample, turned: list[Turned]) -> Scalar:
    """s = sum c_k qd_k [rad/s]."""
    return _rate(sample.qd, turned)


def acceleration_of(sample: Sample, turned: list[Turned]) -> Scalar:
    """sdd = sum c_k qdd_k [rad/s^2]."""
    return _rate(sample.qdd, turned)


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    for motor, turned in coupled_motors(sample.model, scene):
        speed, acceleration = speed_of(sample, turned), acceleration_of(sample, turned)
        terms = terms.with_torques(torques(turned, torque(motor, speed, acceleration, scene.slip_speed)))
    return terms


def stored(sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
    """sum G^2 J s^2 / 2 [J]."""
    moving = ((motor, speed_of(sample, turned)) for motor, turned in coupled_motors(sample.model, scene))
    return total((0.5 * motor.reflected) * (speed * speed) for motor, speed in moving)


def lost(sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
    """sum of friction times s [W]."""
    moving = ((motor, speed_of(sample, turned)) for motor, turned in coupled_motors(sample.model, scene))
    return total(torque(motor, speed, 0.0, scene.slip_speed) * speed for motor, speed in moving)


EFFECT = Effect(
    "coupled motor",
    "c_j (G^2 J sdd + d s + f sign(s)) with s = sum c_k qd_k over the joints that a motor turns with",
    why,
    add,
    stored=stored,
    lost=lost,
)
