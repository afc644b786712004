"""Fluid: buoyancy and quadratic drag on links in still or streaming water or air."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.programs.vectors import cross, sign
from robodyn.robot.kinematics import Pose, Velocity, Wrench, poses, velocities
from robodyn.robot.model import Model
from robodyn.scene.parts import Immersed
from robodyn.scene.scene import Scene


def why(model: Model, scene: Scene, zero_columns: ZeroColumns) -> Verdict:
    links = [immersed.link for immersed in scene.immersed if immersed.volume or any(immersed.drag_area)]
    some = f"{scene.fluid_density:g} kg/m^3 around {', '.join(links)}"
    return Verdict.of(scene.fluid_density and links, "the scene has no fluid", some)


def _on_body(immersed: Immersed, sample: Sample, scene: Scene, pose: Pose, moving: Velocity) -> tuple[int, Wrench]:
    """Buoyancy -rho V g and drag -rho/2 C_d A_k |u_k| u_k along each axis k of the link, both at the centre of volume.

    u is the centre's velocity relative to the fluid, in the link's axes.
    """
    body, R, p = sample.model.links[immersed.link]
    centre = p + R @ np.array(immersed.centre)
    streaming = pose.R.T @ np.array(scene.fluid_velocity, dtype=float)
    u = R.T @ (moving.v + cross(moving.w, centre) - streaming)
    area = 0.5 * scene.fluid_density * np.array(immersed.drag_area)
    drag = np.array([-(c * (sign(x) * (x * x))) for c, x in zip(area, u, strict=True)])
    buoyancy = pose.R.T @ (-scene.fluid_density * immersed.volume * np.array(scene.gravity, dtype=float))
    f = R @ drag + buoyancy
    return body, Wrench(f, cross(centre, f))


def add(terms: Terms, sample: Sample, scene: Scene) -> Terms:
    joints = sample.motions()
    where, moving = poses(sample.model.parents, joints), velocities(sample.model.parents, joints)
    acting = []
    for immersed in scene.immersed:
        body = sample.model.links[immersed.link].body
        acting.append(_on_body(immersed, sample, scene, where[body], moving[body]))
    return replace(terms, wrenches=terms.wrenches + tuple(acting))


EFFECT = Effect("fluid", "buoyancy -rho V g and drag rho/2 C_d A v^2 against the motion, link by link", why, add)
