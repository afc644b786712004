"""Joint springs: a torque k (q - q0) that the actuator must hold."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.programs.vectors import Scalar, total
from robodyn.robot.kinematics import Motion
from robodyn.robot.model import Joint, Model
from robodyn.scene.parts import Spring
from robodyn.scene.scene import Scene


def _sprung(model: Model, scene: Scene) -> Iterator[tuple[int, Joint, Spring]]:
    for i, body in enumerate(model.bodies):
        spring = scene.spring.get(body.joint.name)
        if spring is not None and spring.stiffness:
            yield i, body.joint, spring


def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
    names = [joint.name for _, joint, _ in _sprung(model, scene)]
    return Verdict.of(names, "the scene has no spring", f"springs at {', '.join(names)}")


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    torques = (
        (i, spring.stiffness * (sample.position(joint) - spring.rest))
        for i, joint, spring in _sprung(sample.model, scene)
    )
    return terms.with_torques(torques, through_gear=True)


def stored(sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
    """sum k (q - q0)^2 / 2 [J]."""
    stretched = ((k, sample.position(joint) - k.rest) for _, joint, k in _sprung(sample.model, scene))
    return total((0.5 * spring.stiffness) * (stretch * stretch) for spring, stretch in stretched)


EFFECT = Effect("joint spring", "k (q - q0)", why, add, stored=stored)
