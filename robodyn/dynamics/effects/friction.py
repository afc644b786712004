"""Which friction a joint has: the scene's word, else the description's."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Friction, Scene


def friction_of(joint: Joint, scene: Scene) -> Friction:
    """The scene's friction for this joint, else `<dynamics damping friction>` of the description."""
    if joint.name in scene.friction:
        return scene.friction[joint.name]
    return Friction(viscous=joint.damping, forward=joint.friction, backward=-joint.friction)


def rubbing(model: Model, scene: Scene) -> Iterator[tuple[int, Joint, Friction]]:
    """Every hinge and slide with its friction, and the body that it carries."""
    for i, body in enumerate(model.bodies):
        if body.joint.kind in ("revolute", "prismatic"):
            yield i, body.joint, friction_of(body.joint, scene)
