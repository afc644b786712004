"""Coriolis and centrifugal forces: joints and base move."""

from __future__ import annotations

from dataclasses import replace

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene


def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
    moving = sum(("qd", i) not in zero_columns for i in range(model.n))
    return Verdict.of(moving, "nothing moves", f"{moving} of {model.n} velocities are not zero")


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    return replace(terms, qd=sample.qd)


EFFECT = Effect("coriolis", "c(q, qd): Coriolis and centrifugal forces, those of a turning base included", why, add)
