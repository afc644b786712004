"""Jacobians of loops and contacts, traced once per model and scene, and the tree on which their forces are wrenches."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.initial_state import independent_equations
from robodyn.dynamics.loops.closed_chain import closure_of
from robodyn.dynamics.loops.closure import Closure, held
from robodyn.dynamics.plan import Plan, ready
from robodyn.programs.derivative import Direction, jacobian
from robodyn.programs.program import traced
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import IDENTITY, Scalar, cross, product, vector
from robodyn.robot.kinematics import motions, poses, velocities
from robodyn.robot.model import Model
from robodyn.scene.scene import GROUND, Contact, ContactCost, ExternalWrench, Scene, Vector
from robodyn.support.floats import Floats, einsum

PARTS = ("fx", "fy", "fz", "mx", "my", "mz")


def columns_of(name: str) -> tuple[str, ...]:
    """Return the columns of the wrench of a loop or a contact on its link, as tables of results call them."""
    return tuple(f"{part}_{name}" for part in PARTS)


def reaction_columns_of(name: str) -> tuple[str, ...]:
    return tuple(f"reaction {column}" for column in columns_of(name))


def open_scene(scene: Scene) -> Scene:
    return replace(
        scene, loops=(), contacts=(), actuated=None, passive=(), share=Scene.share, weights={}, weight=Scene.weight,
        contact_cost=ContactCost(),
    )  # fmt: skip


@lru_cache(maxsize=16)
def tree_scene(model: Model, scene: Scene) -> Scene:
    """Return the scene in which constraints are wrenches, by columns of `constraint_columns`: a loop's on its link at
    its point, in the axes of the other, and the opposite on that; a contact's at `middle`, in the axes of the ground.
    """

    def wrench(link: str, columns: tuple[str, ...], point: Vector, frame: str, cause: str, to: str) -> ExternalWrench:
        a, b, c, d, e, f = columns
        return ExternalWrench(link, (a, b, c), (d, e, f), point, frame, cause, to)

    wrenches = [*scene.wrenches]
    for loop in scene.loops:
        to = "" if loop.to == GROUND and GROUND not in model.links else loop.to
        wrenches.append(wrench(loop.link, columns_of(loop.name), loop.point, "world", "loop", to))
        if to:
            wrenches.append(wrench(to, reaction_columns_of(loop.name), loop.to_point, "link", "loop", ""))
    for contact in scene.contacts:
        wrenches.append(wrench(contact.link, columns_of(contact.name), middle(contact), "world", "contact", ""))
    return replace(open_scene(scene), wrenches=tuple(wrenches))


def constraint_columns(scene: Scene) -> tuple[str, ...]:
    """Return all columns that `tree_scene` adds: of loops and contacts, then of loops on the other links."""
    own = [column for name in scene.constraint_names for column in columns_of(name)]
    return (*own, *(column for loop in scene.loops for column in reaction_columns_of(loop.name)))


def middle(contact: Contact) -> Vector:
    """Return the mean of a contact's points, in the frame of its link [m]."""
    x, y, z = np.mean(contact.points, axis=0).tolist()
    return x, y, z


def normal_of(contact: Contact, scene: Scene) -> Floats:
    """Return (3,) the unit normal of a contact in the axes of the ground; without gravity it is up, along z."""
    g = np.asarray(scene.gravity)
    against = -g if g.any() else np.array((0.0, 0.0, 1.0))
    n = np.asarray(against if contact.normal is None else contact.normal, dtype=float)
    n = n / np.abs(n).max()
    return np.asarray(n / np.sqrt((n * n).sum()))


class LoopJacobian(NamedTuple):
    """For N samples and m equations of L loops: J (N, m, n), phi (N, m) [m or rad], moments (N, m, 3) on the link about
    its point for a multiplier of 1, and gaps (N, L, 3) of its point from the other's [m], both in the other's axes."""

    J: Floats
    error: Floats
    moments: Floats
    gaps: Floats


@lru_cache(maxsize=16)
def closures(plan: Plan) -> tuple[Closure, ...]:
    """Return the scene's loops, found in the model as it is, with all their equations: those that others imply carry
    their part of the least forces. Beside contacts, whose forces are found with independent ones,
    `independent_equations`."""
    whole = tuple(closure_of(plan.model, loop) for loop in plan.scene.loops)
    if not plan.scene.contacts or not whole:
        return whole
    kept = independent_equations(plan).closures
    return tuple(replace(one, equations=each.equations) for one, each in zip(whole, kept, strict=True))


def loop_jacobian(plan: Plan, q: Floats, executor: str = "auto") -> LoopJacobian:
    """Return what the loops' equations are at q (N, nq), to 1e-14 of the largest entry of J; none without loops."""
    of = [len(closure.equations) for closure in closures(plan)]
    m, n, samples = sum(of), plan.model.n, len(q)
    if not of:
        return LoopJacobian(*(np.zeros((samples, 0, *more)) for more in ((n,), (), (3,), (3,))))
    out = ready(_loop_program, plan).run({"q": q}, samples, executor=executor).values
    J, error, moments, gaps = np.split(out, np.cumsum([m * n, m, 3 * m]), axis=1)
    return LoopJacobian(
        J.reshape(samples, m, n), error, moments.reshape(samples, m, 3), gaps.reshape(samples, len(of), 3)
    )


class ContactJacobian(NamedTuple):
    """At N samples, for K points of all contacts: J (N, 3 K, n), arms from the middle of their contact (N, K, 3) [m],
    places and speeds (N, K, 3) [m, m/s], all in the axes of the ground."""

    J: Floats
    arms: Floats
    places: Floats
    speeds: Floats


def contact_jacobian(plan: Plan, q: Floats, qd: Floats, executor: str = "auto") -> ContactJacobian:
    """Return where the contacts' points are and what forces there do, at q (N, nq) and qd (N, n)."""
    scene, n, samples = plan.scene, plan.model.n, len(q)
    points = [len(contact.points) for contact in scene.contacts]
    K = sum(points)
    if not K:
        return ContactJacobian(*(np.zeros((samples, 0, k)) for k in (n, 3, 3, 3)))
    out = ready(_contact_program, plan).run({"q": q, "qd": qd}, samples, executor=executor).values
    units, places, speeds = np.split(out, np.cumsum([6 * n * len(points), 3 * K]), axis=1)
    units = units.reshape(samples, len(points), 6, n)
    places, speeds = (each.reshape(samples, K, 3) for each in (places, speeds))
    arms, J, at = np.empty((samples, K, 3)), np.empty((samples, K, 3, n)), 0
    for c, count in enumerate(points):
        k = slice(at, at + count)
        arms[:, k] = places[:, k] - places[:, k].mean(axis=1, keepdims=True)
        J[:, k] = units[:, c, None, :3]
        for axis in range(3):
            moment = cross(arms[:, k].transpose(2, 0, 1), IDENTITY[axis])
            J[:, k, axis] += einsum("jsp,sjn->spn", moment, units[:, c, 3:])
        at += count
    return ContactJacobian(J.reshape(samples, 3 * K, n), arms, places, speeds)


@traced
def _loop_program(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    sample = plan.sample(tape)
    nothing = [0.0] * sample.model.n
    still = motions(sample.model, sample.q, nothing, nothing)
    found = [(closure, held(closure, closure.relative(sample.model, still))) for closure in closures(plan)]
    yield from (row.get(rate, 0.0) for _, here in found for row in here.J for rate in range(sample.model.n))
    yield from (error for _, here in found for error in here.error)
    for closure, here in found:
        for equation in closure.equations:
            yield from equation.moment(here.places[0].B)
    for _, here in found:
        yield from here.places[0].d


@traced
def _contact_program(plan: Plan, tape: Tape) -> Iterable[Scalar]:
    """Jacobians of the contacts' middles, moments first; where their points are, and how they move."""
    sample = replace(plan.sample(tape), qdd=(0.0,) * plan.model.n)
    joints, parents = sample.motions(), sample.model.parents
    where, moving = poses(parents, joints), velocities(parents, joints)
    directions: list[Direction] = [{rate: 1.0} for rate in sample.qd]
    places: list[Scalar] = []
    speeds: list[Scalar] = []
    for contact in plan.scene.contacts:
        body, R, p = sample.model.links[contact.link]
        turn, (w, v) = where[body].R, moving[body]
        r = p + product(R, vector(*middle(contact)))
        motion = [*product(turn, v + cross(w, r)), *product(turn, w)]
        yield from (entry for row in jacobian(motion, directions) for entry in row)
        for point in contact.points:
            r = p + product(R, vector(*point))
            places += [*(where[body].p + product(turn, r))]
            speeds += [*product(turn, v + cross(w, r))]
    yield from (*places, *speeds)


def loop_wrenches(plan: Plan, loops: LoopJacobian, multipliers: Floats) -> tuple[Floats, Floats]:
    """Return (N, 6 L) the wrench of each loop on its link, by multipliers (N, m) [N, N m], and that on the other link:
    each at the link's own point, in the axes of the other link."""
    own, others, at = [np.zeros((len(multipliers), 0))], [np.zeros((len(multipliers), 0))], 0
    for closure, gap in zip(closures(plan), loops.gaps.transpose(1, 0, 2), strict=True):
        k = slice(at, at + len(closure.equations))
        force = einsum("nk,ki->ni", multipliers[:, k], np.array([each.D for each in closure.equations]).reshape(-1, 3))
        moment = einsum("nk,nki->ni", multipliers[:, k], loops.moments[:, k])
        own += [force, moment]
        others += [-force, -moment - np.cross(gap, force)]
        at = k.stop
    return np.hstack(own), np.hstack(others)
