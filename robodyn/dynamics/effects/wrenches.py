"""Wrenches ON links: of the surroundings, of fluids, and those by which loops and contacts hold the robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.programs.vectors import Array, cross, sign
from robodyn.robot.kinematics import Wrench, poses, velocities
from robodyn.robot.model import Model
from robodyn.scene.scene import Entry, ExternalWrench, Scene


def acting(scene: Scene, cause: str) -> list[ExternalWrench]:
    """The wrenches of one cause that are not nothing."""
    return [each for each in scene.wrenches if each.cause == cause and (any(each.force) or any(each.moment))]


class WrenchEffect(Effect):
    """The scene's wrenches of one cause."""

    def __init__(self, name: str, cause: str, none: str, adds: str) -> None:
        """Args: none: why it is off where there is none."""
        self.name, self.cause, self.none, self.adds = name, cause, none, adds

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        links = dict.fromkeys(wrench.link for wrench in acting(scene, self.cause))
        return Verdict.of(links, self.none, f"acts on {', '.join(links)}")

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        where = poses(sample.model.parents, sample.motions())
        more = []
        for wrench in acting(scene, self.cause):
            body, R, p = sample.model.links[wrench.link]
            if wrench.axes:
                other, turn, _ = sample.model.links[wrench.axes]
                axes = where[body].R.T @ (where[other].R @ turn)
            else:
                axes = {"link": R, "base": where[body].R.T @ where[0].R, "world": where[body].R.T}[wrench.frame]
            f = axes @ _entries(wrench.force, sample)
            n = axes @ _entries(wrench.moment, sample) + cross(p + R @ np.array(wrench.point), f)
            more.append((body, Wrench(f, n)))
        return replace(terms, wrenches=(*terms.wrenches, *more))


def _entries(entries: tuple[Entry, Entry, Entry], sample: Sample) -> Array:
    return np.array([sample.columns[entry] if isinstance(entry, str) else float(entry) for entry in entries])


class Fluid(Effect):
    """Buoyancy and quadratic drag on links in still or streaming water or air."""

    name, adds = "fluid", "buoyancy -rho V g and drag rho/2 C_d A v^2 against the motion, link by link"

    def why(self, model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
        links = [immersed.link for immersed in scene.immersed if immersed.volume or any(immersed.drag_area)]
        some = f"{scene.fluid_density:g} kg/m^3 around {', '.join(links)}"
        return Verdict.of(scene.fluid_density and links, "the scene has no fluid", some)

    def add(self, terms: Terms, sample: Sample, scene: Scene) -> Terms:
        """Buoyancy and drag -rho/2 C_d A_k |u_k| u_k along each axis k of a link, both at its centre of volume. u is
        the centre's velocity relative to the fluid, in the link's axes."""
        joints = sample.motions()
        where, moving = poses(sample.model.parents, joints), velocities(sample.model.parents, joints)
        acting = []
        for immersed in scene.immersed:
            body, R, p = sample.model.links[immersed.link]
            to_body, (w, v) = where[body].R.T, moving[body]
            centre = p + R @ np.array(immersed.centre)
            u = R.T @ (v + cross(w, centre) - to_body @ np.array(scene.fluid_velocity, dtype=float))
            area = 0.5 * scene.fluid_density * np.array(immersed.drag_area)
            drag = np.array([-(c * (sign(x) * (x * x))) for c, x in zip(area, u, strict=True)])
            weight = scene.fluid_density * immersed.volume * np.array(scene.gravity, dtype=float)
            f = R @ drag + to_body @ -weight
            acting.append((body, Wrench(f, cross(centre, f))))
        return replace(terms, wrenches=(*terms.wrenches, *acting))


_ADDS = "-J^T w for a force and a moment that act on a link"
EXTERNAL = WrenchEffect("external wrench", "surroundings", "the scene has no external wrench", _ADDS)
LOOPS = WrenchEffect("loop forces", "loop", "no loop is closed", "-J^T lambda of the forces that close loops")
CONTACTS = WrenchEffect("contact forces", "contact", "no link stands on anything", "-J^T f of what links stand on")
FLUID = Fluid()
