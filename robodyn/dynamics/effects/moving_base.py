"""Moving base: the base accelerates. Its angular velocity enters with the other velocities, in `coriolis`."""

from __future__ import annotations

from dataclasses import replace

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene


def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
    if not model.floating:
        return Verdict(False, "the base is fixed")
    if all(("qdd", i) in zero_columns for i in range(6)):
        return Verdict(False, "the base does not accelerate")
    return Verdict(True, "the base follows the base columns; its angular velocity is counted under coriolis")


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    return replace(terms, qdd=sample.qdd[:6] + terms.qdd[6:])


EFFECT = Effect("moving base", "what the base's acceleration asks of the joints", why, add)
