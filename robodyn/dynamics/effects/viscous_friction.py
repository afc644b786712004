"""Viscous friction: a torque d qd."""

from __future__ import annotations

from robodyn.dynamics.effects.effect import Effect, Sample, Still, Terms, Verdict
from robodyn.dynamics.effects.friction import rubbing
from robodyn.programs.vectors import Scalar
from robodyn.robot.model import Model
from robodyn.robot.motion_types import Motion
from robodyn.scene.scene import Scene


def why(model: Model, scene: Scene, still: Still) -> Verdict:
    damped = [joint for _, joint, friction in rubbing(model, scene) if friction.viscous]
    if not damped:
        return Verdict(False, "no joint has damping")
    if all(("qd", joint.rate) in still for joint in damped):
        return Verdict(False, "no damped joint moves")
    return Verdict(True, f"{len(damped)} damped joints")


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    return terms.with_torques(
        (i, friction.viscous * sample.speed(joint)) for i, joint, friction in rubbing(sample.model, scene)
    )


def lost(sample: Sample, terms: Terms, scene: Scene, motions: list[Motion]) -> Scalar:
    """sum d qd^2 [W]."""
    power: Scalar = 0.0
    for _, joint, friction in rubbing(sample.model, scene):
        power = power + friction.viscous * (sample.speed(joint) * sample.speed(joint))
    return power


EFFECT = Effect("viscous friction", "d qd", why, add, lost=lost)
