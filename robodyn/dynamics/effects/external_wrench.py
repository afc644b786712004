"""Wrenches ON links: those of the surroundings, and those by which loops and contacts hold the robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.programs.vectors import Array, cross
from robodyn.robot.kinematics import Pose, Wrench, poses
from robodyn.robot.model import Model
from robodyn.scene.parts import Entry, ExternalWrench
from robodyn.scene.scene import Scene


def acting(scene: Scene, cause: str) -> list[ExternalWrench]:
    """Return the wrenches of one cause that are not nothing."""
    return [each for each in scene.wrenches if each.cause == cause and (any(each.force) or any(each.moment))]


def _entries(entries: tuple[Entry, Entry, Entry], sample: Sample) -> Array:
    return np.array([sample.columns[entry] if isinstance(entry, str) else float(entry) for entry in entries])


def _on_body(wrench: ExternalWrench, sample: Sample, where: list[Pose]) -> tuple[int, Wrench]:
    """Return the body that the wrench acts on, and the wrench about that body's origin in its axes."""
    body, R, p = sample.model.links[wrench.link]
    if wrench.axes:
        other, turn, _ = sample.model.links[wrench.axes]
        axes = where[body].R.T @ (where[other].R @ turn)
    else:
        axes = {"link": R, "base": where[body].R.T @ where[0].R, "world": where[body].R.T}[wrench.frame]
    f = axes @ _entries(wrench.force, sample)
    return body, Wrench(f, axes @ _entries(wrench.moment, sample) + cross(p + R @ np.array(wrench.point), f))


def wrench_effect(name: str, cause: str, none: str, adds: str) -> Effect:
    """Return the effect of the scene's wrenches of one cause."""

    def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        links = dict.fromkeys(wrench.link for wrench in acting(scene, cause))
        return Verdict.of(links, none, f"acts on {', '.join(links)}")

    def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
        where = poses(sample.model.parents, sample.motions())
        more = tuple(_on_body(wrench, sample, where) for wrench in acting(scene, cause))
        return replace(terms, wrenches=terms.wrenches + more)

    return Effect(name, adds, why, add)


EFFECT = wrench_effect(
    "external wrench",
    "surroundings",
    "the scene has no external wrench",
    "-J^T w for a force and a moment that act on a link",
)
