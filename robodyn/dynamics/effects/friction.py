"""Friction at joints: viscous, Coulomb's with Stribeck's excess, and a share of the load that passes the gear."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.dynamics.recursions.newton_euler import along_joint, newton_euler
from robodyn.programs.vectors import Scalar, exp, sign, sqrt, total
from robodyn.robot.kinematics import Motion, Wrench
from robodyn.robot.kinematics import motions as motions_of
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Friction, Scene


def friction_of(joint: Joint, scene: Scene) -> Friction:
    """Return the scene's friction for this joint, else `<dynamics damping friction>` of the description."""
    if joint.name in scene.friction:
        return scene.friction[joint.name]
    return Friction(viscous=joint.damping, forward=joint.friction, backward=-joint.friction)


def joints_with_friction(model: Model, scene: Scene) -> Iterator[tuple[int, Joint, Friction]]:
    """Every hinge and slide with its friction, and the body that it carries."""
    for i, body in enumerate(model.bodies):
        if body.joint.kind in ("revolute", "prismatic"):
            yield i, body.joint, friction_of(body.joint, scene)


class ViscousFriction(Effect):
    """A torque d qd."""

    name, adds = "viscous friction", "d qd"

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        damped = [joint for _, joint, friction in joints_with_friction(model, scene) if friction.viscous]
        moving = "qd", zero_columns
        return Verdict.of_joints(damped, moving, "no joint has damping", "no damped joint moves", "damped joints")

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        found = joints_with_friction(sample.model, scene)
        return terms.with_torques((i, friction.viscous * sample.speed(joint)) for i, joint, friction in found)

    def lost(self, sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
        """sum d qd^2 [W]."""
        moving = joints_with_friction(sample.model, scene)
        return total(friction.viscous * (sample.speed(joint) * sample.speed(joint)) for _, joint, friction in moving)


def direction(qd: Scalar, slip_speed: float = 0.0) -> Scalar:
    """sign(qd), or `qd / sqrt(qd^2 + slip_speed^2)`, which leaves rest without a jump."""
    square = slip_speed * slip_speed
    return qd / sqrt(qd * qd + square) if square else sign(qd)


def coulomb_torque(friction: Friction, qd: Scalar, slip_speed: float = 0.0) -> Scalar:
    """`forward` for qd > 0, `backward` for qd < 0, 0 at rest; with Stribeck's excess towards `stribeck` at low speed [N
    m or N]. `(forward - backward) / 2 s + (forward + backward) / 2 s^2`, s being `direction`; and `(stribeck - Coulomb)
    exp(-(qd / v_s)^2)` with the same sign."""
    s = direction(qd, slip_speed)
    odd, even = 0.5 * (friction.forward - friction.backward), 0.5 * (friction.forward + friction.backward)
    coulomb = odd * s + even * (s * s)
    if friction.stribeck is None:
        return coulomb
    ratio = qd / friction.stribeck_velocity
    return coulomb + (friction.stribeck * s - coulomb) * exp(-(ratio * ratio))


class CoulombFriction(Effect):
    """A torque that opposes motion whatever its speed; none at rest, as sign(0) = 0."""

    name = "coulomb friction"
    adds = "f sign(qd), sign(0) = 0; different forwards and backwards, and Stribeck's excess, if given"

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        dry = [joint for _, joint, friction in joints_with_friction(model, scene) if friction.dry]
        none, some = "no joint has Coulomb friction", "joints with Coulomb friction"
        return Verdict.of_joints(dry, ("qd", zero_columns), none, "no joint with Coulomb friction moves", some)

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        return terms.with_torques(
            (i, coulomb_torque(friction, sample.speed(joint), scene.slip_speed))
            for i, joint, friction in joints_with_friction(sample.model, scene)
        )

    def lost(self, sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
        """sum of torque times speed [W]."""
        moving = ((friction, sample.speed(joint)) for _, joint, friction in joints_with_friction(sample.model, scene))
        return total(coulomb_torque(friction, speed, scene.slip_speed) * speed for friction, speed in moving)


class LoadFriction(Effect):
    """A share of the torque that passes the gear, whichever way that acts: `tau = tau_l + load |tau_l| s(qd) + own
    friction + rotor`, where tau_l is what moves and holds the links, springs between them included."""

    name = "load friction"
    adds = "load abs(tau_l) sign(qd), tau_l being what the gear passes on to the links and the springs between them"
    by_load = True

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        joints = [joint for _, joint, rub in joints_with_friction(model, scene) if rub.load]
        none, some = "no joint has friction that grows with load", "joints whose friction grows with load"
        return Verdict.of_joints(joints, ("qd", zero_columns), none, "no joint with such friction moves", some)

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        load = {
            i: rub.load * direction(sample.speed(joint), scene.slip_speed)
            for i, joint, rub in joints_with_friction(sample.model, scene)
            if rub.load
        }
        return replace(terms, load=load)

    def lost(self, sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
        """sum load |tau_l| s(qd) qd [W]; terms are those of the sample's accelerations."""
        model = sample.model
        joints = motions_of(model, sample.q, terms.qd, terms.qdd)
        reactions = newton_euler(model.parents, joints, terms.inertias, terms.gravity, terms.wrenches)
        return total(
            torque * sample.speed(model.bodies[i].joint) for i, torque in load_torques(terms, model, reactions)
        )


def load_torques(terms: Terms, model: Model, reactions: Sequence[Wrench]) -> Iterator[tuple[int, Scalar]]:
    """(body, `load |tau_l|`) of the torque tau_l through each gear."""
    for i, share in terms.load.items():
        passed = along_joint(model.bodies[i].joint, reactions[i]) + terms.through_gear.get(i, 0.0)
        yield i, share * (passed * sign(passed))


VISCOUS, COULOMB, LOAD = ViscousFriction(), CoulombFriction(), LoadFriction()
