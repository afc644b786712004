"""Mimic joints: they follow their master's coordinate, and their torques are reflected onto it."""

from __future__ import annotations

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene


def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
    names = [body.joint.name for body in model.bodies if body.joint.mimics is not None]
    some = f"{len(names)} joints follow others ({', '.join(names[:4])}{', ...' * (len(names) > 4)})"
    return Verdict.of(names, "no joint mimics another", some)


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    """Nothing: that a joint follows another is part of the model, so every other effect already sees it."""
    return terms


EFFECT = Effect(
    "mimic", "nothing by itself: torques of a follower, times its multiplier, are part of its master's", why, add
)
