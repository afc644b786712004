"""External wrenches: forces and moments that the surroundings exert ON links."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.programs.vectors import Array, cross
from robodyn.robot.kinematics import Pose, Wrench, poses
from robodyn.robot.model import Model
from robodyn.scene.scene import Entry, ExternalWrench, Scene


def _acting(scene: Scene) -> list[ExternalWrench]:
    return [wrench for wrench in scene.wrenches if any(wrench.force) or any(wrench.moment)]


def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
    links = [wrench.link for wrench in _acting(scene)]
    return Verdict.of(links, "the scene has no external wrench", f"acts on {', '.join(links)}")


def _entries(entries: tuple[Entry, Entry, Entry], sample: Sample) -> Array:
    return np.array([sample.columns[entry] if isinstance(entry, str) else float(entry) for entry in entries])


def _on_body(wrench: ExternalWrench, sample: Sample, where: list[Pose]) -> tuple[int, Wrench]:
    """Return the body that the wrench acts on, and the wrench about that body's origin in its axes."""
    body, R, p = sample.model.links[wrench.link]
    axes = {"link": R, "base": where[body].R.T @ where[0].R, "world": where[body].R.T}[wrench.frame]
    f = axes @ _entries(wrench.force, sample)
    return body, Wrench(f, axes @ _entries(wrench.moment, sample) + cross(p + R @ np.array(wrench.point), f))


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    where = poses(sample.model.parents, sample.motions())
    acting = tuple(_on_body(wrench, sample, where) for wrench in _acting(scene))
    return replace(terms, wrenches=terms.wrenches + acting)


EFFECT = Effect("external wrench", "-J^T w for a force and a moment that act on a link", why, add)
