"""A robot in one state as free bodies: weight, inertia, reactions, drives and what the surroundings do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.arrays import arrays_of, zero_columns
from robodyn.dynamics.constraints.inverse import as_tree
from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.plan import applied, plan
from robodyn.dynamics.recursions.newton_euler import joint_torques, newton_euler
from robodyn.equations.free_body.actions import (
    Applied,
    applied_wrenches,
    at_joint,
    cut,
    inertial,
    torques_at_joints,
    weight,
)
from robodyn.equations.free_body.types import Action, FreeBodies, FreeBody, JointRow
from robodyn.errors import InputError
from robodyn.programs.vectors import narrowed_all
from robodyn.robot.kinematics import Motion, accelerations, motions, poses, velocities
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_load, refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.wording import figure, shown


def free_bodies(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike = 0.0,
    qdd: ArrayLike = 0.0,
    *,
    scene: Scene = DEFAULT,
    columns: Mapping[str, float] | None = None,
) -> FreeBodies:
    """Return every body of a robot cut free, with all forces and moments on it: they add up to zero.

    The reactions come from the force recursion; weights and inertial forces from each body's own acceleration and
    Euler's laws about its mass centre. Their balance therefore checks one against the other.

    Args:
        model: of `robodyn.load`.
        q: (nq,) rad or m; qd, qdd: (n,) per s and per s^2, as for `inverse_dynamics`; `0` is at rest.
        scene: what surrounds the robot; its payloads are part of their bodies.
        columns: numbers for the columns that the scene's wrenches name.

    Raises:
        InputError: a shape does not fit the model, or there is more than one sample.

    Accuracy: forces, and moments about each body's origin, add up to zero within 1e-14 of the largest on any body, for
    chains of up to 100 bodies.
    """
    refuse_others(model, scene)
    refuse_load(scene)
    given: Mapping[str, ArrayLike] = columns or {}
    missing: Floats = np.zeros(model.n)
    if scene.constrained:
        scene, given, missing = as_tree(model, (q, qd, qdd), scene, given)
    sources, shape = arrays_of(model, {"q": q, "qd": qd, "qdd": qdd}, scene, given)
    if shape:
        raise InputError(f"{shape} samples", remedy="a free-body diagram is of one state")
    a_plan = plan(model, scene, zero_columns(sources))
    state = {name: tuple(values[0].tolist()) for name, values in sources.items() if values.size or name != "columns"}
    extra = dict(zip(scene.columns, state.pop("columns", ()), strict=True))
    sample = Sample(model, state["q"], state["qd"], state["qdd"], extra)
    terms = applied(a_plan.effects, sample, scene)
    joints = motions(model, sample.q, terms.qd, terms.qdd)
    wrenches = narrowed_all(newton_euler(model.parents, joints, terms.inertias, terms.gravity, terms.wrenches))
    torques = torques_at_joints(a_plan.effects, sample, scene)
    cuts = [cut(i, model, wrench, torques) for i, wrench in enumerate(wrenches)]
    around = applied_wrenches(a_plan.effects, sample, scene)
    bodies = tuple(_cut_free(model, terms, joints, cuts, around))
    tau = joint_torques(model, joints, wrenches, terms.at_joint)
    found = _found(scene, sample, bodies, cuts, tau)
    return replace(found, warnings=(*_not_given(model, missing), *found.warnings))


def _not_given(model: Model, missing: Floats) -> Iterator[str]:
    """Yield a sentence on each passive rate at which the motion takes what nothing gives.

    Args:
        missing: (n,) N m or N.
    """
    slides = {joint.name for joint in model.independent if joint.kind == "prismatic"}
    for name, value in zip(model.rates, missing.tolist(), strict=True):
        if value:
            unit = "N" if name in slides or name[-3:] in ("_vx", "_vy", "_vz") else "N m"
            yield f"nothing drives {shown(name)}, and the motion takes {figure(value)} {unit} there, shown as its drive"


def _cut_free(
    model: Model, terms: Terms, joints: list[Motion], cuts: list[JointRow], around: list[Applied]
) -> Iterator[FreeBody]:
    """Yield each body with what acts on it."""
    parents = model.parents
    moving, speeding = narrowed_all(velocities(parents, joints)), narrowed_all(accelerations(parents, joints))
    where, joints = narrowed_all(poses(parents, joints)), narrowed_all(joints)
    for i, body in enumerate(model.bodies):
        own = terms.inertias[i]
        children = [k for k, parent in enumerate(parents) if parent == i]
        heavy = bool(own.m or np.any(own.I))
        acting: list[Action] = [
            *([weight(own, where[i], terms.gravity), inertial(own, moving[i], speeding[i])] if heavy else []),
            *(action for k, action in around if k == i),
            *at_joint(cuts[i], cuts[i].parent),
        ]
        for k in children:
            acting += at_joint(cuts[k], model.bodies[k].name, joints[k], -1.0)
        ends = tuple((k, joints[k].p) for k in children)
        links = tuple(name for name, frame in model.links.items() if frame.body == i)
        yield FreeBody(i, body.name, links, float(own.m), own.centre_of_mass, where[i], tuple(acting), ends)


def _found(
    scene: Scene, sample: Sample, bodies: tuple[FreeBody, ...], cuts: list[JointRow], tau: list[float]
) -> FreeBodies:
    model = sample.model
    tiny = np.finfo(float).tiny
    force_scale = max((np.abs(a.force).max() for body in bodies for a in body.actions), default=0.0)
    moment_scale = max((np.abs(a.at_origin).max() for body in bodies for a in body.actions), default=0.0)
    return FreeBodies(
        model.name,
        model.file,
        dict(zip(model.coordinates, sample.q, strict=True)),
        dict(zip(model.rates, sample.qd, strict=True)),
        dict(zip(model.rates, sample.qdd, strict=True)),
        scene.gravity,
        bodies,
        tuple(cuts),
        dict(zip(model.rates, map(float, tau), strict=True)),
        max(float(np.abs(body.force).max()) for body in bodies) / max(float(force_scale), tiny),
        max(float(np.abs(body.moment).max()) for body in bodies) / max(float(moment_scale), tiny),
        model.notes,
    )
