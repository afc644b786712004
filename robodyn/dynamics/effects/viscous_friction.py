"""Viscous friction: a torque d qd; and which friction a joint has: the scene's word, else the description's."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.programs.vectors import Scalar, total
from robodyn.robot.kinematics import Motion
from robodyn.robot.model import Joint, Model
from robodyn.scene.parts import Friction
from robodyn.scene.scene import Scene


def friction_of(joint: Joint, scene: Scene) -> Friction:
    """Return the scene's friction for this joint, else `<dynamics damping friction>` of the description."""
    if joint.name in scene.friction:
        return scene.friction[joint.name]
    return Friction(viscous=joint.damping, forward=joint.friction, backward=-joint.friction)


def joints_with_friction(model: Model, scene: Scene) -> Iterator[tuple[int, Joint, Friction]]:
    """Yield every hinge and slide with its friction, and the body that it carries."""
    for i, body in enumerate(model.bodies):
        if body.joint.kind in ("revolute", "prismatic"):
            yield i, body.joint, friction_of(body.joint, scene)


def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
    damped = [joint for _, joint, friction in joints_with_friction(model, scene) if friction.viscous]
    moving = "qd", zero_columns
    return Verdict.of_joints(damped, moving, "no joint has damping", "no damped joint moves", "damped joints")


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    return terms.with_torques(
        (i, friction.viscous * sample.speed(joint)) for i, joint, friction in joints_with_friction(sample.model, scene)
    )


def lost(sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
    """sum d qd^2 [W]."""
    moving = joints_with_friction(sample.model, scene)
    return total(friction.viscous * (sample.speed(joint) * sample.speed(joint)) for _, joint, friction in moving)


EFFECT = Effect("viscous friction", "d qd", why, add, lost=lost)
