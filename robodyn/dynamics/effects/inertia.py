"""Inertia: the joints accelerate."""

from __future__ import annotations

from dataclasses import replace

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene


def joint_rates(model: Model) -> range:
    """Return the entries of qd and qdd that belong to joints, not to a moving base."""
    return range(6 if model.floating else 0, model.n)


def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
    moving = sum(("qdd", i) not in zero_columns for i in joint_rates(model))
    return Verdict.of(moving, "no joint accelerates", f"{moving} of {len(joint_rates(model))} coordinates accelerate")


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    first = joint_rates(sample.model).start
    return replace(terms, qdd=terms.qdd[:first] + sample.qdd[first:])


EFFECT = Effect("inertia", "M(q) qdd", why, add)
