"""Payload: a mass fixed to a link, added to its body by the parallel axis theorem."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robodyn.dynamics.effects import gravity
from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.solids.inertia.laws import MASSLESS, combined, inertia_of, symmetric


def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
    loads = [load for load in scene.payloads if load.mass or any(load.inertia)]
    some = ", ".join(f"{load.mass:g} kg on {load.link}" for load in loads)
    return Verdict.of(loads, "the scene has no payload", some)


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    inertias = list(terms.inertias)
    for load in scene.payloads:
        body, R, p = sample.model.links[load.link]
        mass = inertia_of(load.mass, np.array(load.com), symmetric(load.inertia), R, p)
        inertias[body] = combined((inertias[body], mass))
    return replace(terms, inertias=tuple(inertias))


def background(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    """Return the whole motion and gravity, on a robot without mass: what a payload needs to be felt."""
    massless = tuple(MASSLESS for _ in terms.inertias)
    return gravity.add(replace(terms, inertias=massless, qd=sample.qd, qdd=sample.qdd), sample, scene)


EFFECT = Effect(
    "payload",
    "mass, centre of mass and inertia to a link, by the parallel axis theorem",
    why,
    add,
    background=background,
)
