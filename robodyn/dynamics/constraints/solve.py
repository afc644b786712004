"""The forces of loops and contacts along a motion, and the torques that are left to the drives."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from math import prod
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robodyn.dynamics.arrays import arrays_of, numbers, zero_sources
from robodyn.dynamics.constraints.constraint_jacobian import (
    ContactJacobian,
    LoopJacobian,
    closures,
    constraint_columns,
    contact_jacobian,
    loop_jacobian,
    loop_wrenches,
    normal_of,
    open_scene,
    tree_scene,
)
from robodyn.dynamics.constraints.torque_distribution import (
    GOOD,
    Mask,
    Structure,
    TorqueDistribution,
    rank_changes,
    structure,
    torque_distribution,
)
from robodyn.dynamics.contacts.solve import Forces, FreeTerms, Problem, TorqueTerms, contact_forces
from robodyn.dynamics.loops.closure import loops_size
from robodyn.dynamics.plan import Plan, plan, torque_runner
from robodyn.errors import InputError, SceneError
from robodyn.programs.vectors import length, product
from robodyn.robot.limits import binding
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import ALWAYS, AUTO, EFFORT, GROUND, Scene
from robodyn.support.floats import Floats, einsum
from robodyn.support.wording import shown

PIECE = 2048
"""Samples worked on at a time, so that memory does not grow with the motion."""
REFERENCES = 16
"""Samples of the first block by which ranks are decided."""
BALANCED = 1e-9
"""Of the largest generalised force of a sample: a smaller remainder at passive joints is rounding."""
ROUNDING = 1e-12
"""Of weight and forces: what is less is left where these cancel, as gravity and acceleration of a robot that falls."""
CLOSED = 1e-3
"""rad, or of the loops' size and at most m, by which loops may be open."""


class Actuation(NamedTuple):
    """Of a robot's rates.

    passive (n,): those that nothing drives, of passive joints and of floating ones, and the base's where contacts or
    loops to the ground hold it; driven (n,): joints that drive. A base that is neither is held. weights, limits
    (driven,): of the squares of their torques; of effort [N m or N], infinite where there is none.
    """

    passive: Mask
    driven: Mask
    weights: Floats
    limits: Floats

    @property
    def counted(self) -> Mask:
        """(n,) rates that constraints act on: all but those of a base that is held."""
        return np.asarray(self.passive | self.driven)


@lru_cache(maxsize=16)
def actuation(model: Model, scene: Scene) -> Actuation:
    """Return what drives in a scene: joints of `actuated`, or all but those of `passive`; where neither is said, those
    of `drive` in a closed chain that has some, else all. SceneError for an effort limit that is asked for and is none.
    """
    passive, driven = np.zeros(model.n, dtype=bool), np.zeros(model.n, dtype=bool)
    weights, limits = [], []
    actuated = scene.actuated
    if actuated is None and not scene.passive and scene.loops and scene.drive:
        actuated = tuple(scene.drive)
    to_ground = GROUND not in model.links and any(loop.to == GROUND for loop in scene.loops)
    grounded = (bool(scene.contacts) or to_ground) and not scene.held  # a base that moves
    base = 6 if model.floating else 0
    for joint in model.independent:
        if joint.kind == "floating":
            passive[joint.rate : joint.rate + 6] = joint.rate >= base or grounded
            continue
        drives = joint.name in actuated if actuated is not None else joint.name not in scene.passive
        passive[joint.rate], driven[joint.rate] = not drives, drives
        if not drives and joint.name in scene.weights:
            what = f"[weights]: nothing drives {shown(joint.name)}"
            raise SceneError(what, remedy="give weights of joints that drive")
        if drives:
            weights.append(_weight(joint, scene))
            limits.append(binding(joint.effort) or np.inf)
    cost = scene.contact_cost
    if scene.contacts and (cost.torques or cost.within_limits) and not np.isfinite(limits).any():
        what = "[contact_cost] counts torques by their effort limits, and no joint that drives has one"
        raise SceneError(what, remedy="give limits in the description, or leave torques and within_limits out")
    return Actuation(passive, driven, np.array(weights), np.array(limits))


def _weight(joint: Joint, scene: Scene) -> float:
    weight = scene.weights.get(joint.name, scene.weight) if scene.share == "weighted" else 1.0
    if weight != EFFORT:
        return float(weight)
    limit = binding(joint.effort)
    if not limit:
        what = f'[weights]: {shown(joint.name)} has no effort limit, by which "{EFFORT}" weighs'
        raise SceneError(what, remedy="give its weight as a number, or the limit in the description")
    return 1.0 / limit**2


def touching(
    plan: Plan, q: Floats, qd: Floats, time: Floats | None, columns: Mapping[str, Floats], executor: str = "auto"
) -> Mask:
    """Return (N, K) which points touch, contact after contact; InputError for a column or a time that is missing. With
    AUTO each point by itself touches where it is at most `height` above the plane `normal . p = level` and slower than
    `speed`; otherwise a contact touches with all of its points."""
    contacts, at = plan.scene.contacts, 0
    found = np.zeros((len(q), sum(len(contact.points) for contact in contacts)), dtype=bool)
    here = contact_jacobian(plan, q, qd, executor) if any(contact.on == AUTO for contact in contacts) else None
    for contact in contacts:
        k = slice(at, at + len(contact.points))
        at = k.stop
        if contact.on == ALWAYS:
            found[:, k] = True
        elif here is not None and contact.on == AUTO:
            high = product(normal_of(contact, plan.scene), here.places[:, k].transpose(0, 2, 1)) - contact.level
            fast = np.sqrt((here.speeds[:, k] ** 2).sum(axis=2))
            found[:, k] = (high <= contact.height) & (fast <= contact.speed)
        elif isinstance(contact.on, str):
            if contact.on not in columns:
                what = f"[[contact]] {shown(contact.name)} is on by the column {shown(contact.on)}"
                raise InputError(what, remedy="pass it as columns={name: values}")
            found[:, k] = columns[contact.on][:, None] != 0.0
        elif time is None:
            what = f"[[contact]] {shown(contact.name)} is on in intervals of time, and states have none"
            raise InputError(what, remedy="use robodyn.torques of a motion, or a column")
        else:
            found[:, k] = np.any([(time >= start) & (time <= end) for start, end in contact.on], axis=0)[:, None]
    return found


class Found(NamedTuple):
    """For N samples.

    Attributes:
        wrenches: (N, c) by `constraint_columns`.
        tau: (N, n) of the drives; at passive rates what nothing gives, 0 where it is nothing.
        singular: (N,) where loops hold less than elsewhere along the motion.
        crossed: (N,) at what part of the way from the sample before they do so in between; NaN where they do not.
        gap: (N, m) phi of the loops' equations [m or rad].
        forces: (N, K, 3) at the contacts' points, in the axes of the ground [N].
    """

    wrenches: Floats
    tau: Floats
    singular: Mask
    crossed: Floats
    gap: Floats
    forces: Floats
    contacts: ContactJacobian
    problem: Problem | None
    solved: Forces | None


class ConstraintSolver:
    """Finds what loops and contacts bear, piece by piece of one motion.

    Attributes:
        structure: of the loops' equations, by the first samples, and once more by those found to hold more; first None.
        raised: whether samples before the last piece were taken to hold all that the loops can hold, and did not.
        open_drives: (driven,) torques that other forces of loops or contacts than those found could change.
    """

    def __init__(self, plan: Plan, executor: str = "auto") -> None:
        self.plan, self.executor = plan, executor
        self.actuation = actuation(plan.model, plan.scene)
        self.structure: Structure | None = None
        self.raised = False
        self.open_drives: Mask = np.zeros(int(self.actuation.driven.sum()), dtype=bool)
        self._patterns: set[bytes] = set()
        self._last: tuple[int, tuple[Floats, ...]] | None = None  # rank, and A and its decomposition at a last sample
        model, gravity = plan.model, length(np.asarray(plan.scene.gravity))
        self._weight = max(model.total_mass * gravity, 1e-300)
        self._units = np.ones(model.n)
        for joint in model.independent:
            if joint.kind in ("floating", "revolute"):
                turns = slice(joint.rate, joint.rate + (3 if joint.kind == "floating" else 1))
                self._units[turns] = 1.0 / (model.reach or 1.0)

    def pieces(self, samples: int) -> list[slice]:
        return [slice(start, start + PIECE) for start in range(0, samples, PIECE)]

    def solve(self, q: Floats, qd: Floats, tau: Floats, touching: Mask) -> Found:
        """Return x and tau_a of `S_a tau_a + J^T x = tau`, the torques (N, n) of the open tree; N is at most PIECE. See
        `torque_distribution` for loops and `contact_forces` for contacts; touching: (N, K) points that touch."""
        plan, samples = self.plan, len(q)
        loops, contacts = loop_jacobian(plan, q, self.executor), contact_jacobian(plan, q, qd, self.executor)
        self._decide(loops, contacts.J, touching)
        forces, problem, solved = np.zeros((samples, 0, 3)), None, None
        if plan.scene.contacts:
            problem = self._problem(loops, contacts, tau, touching)
            solved = contact_forces(problem, self.executor)
            forces, multipliers = solved.f, solved.free
            singular, crossed = np.zeros(samples, dtype=bool), np.full(samples, np.nan)
        else:
            shared = self._shared(loops, tau)
            multipliers, singular = shared.multipliers, shared.singular | shared.higher
            assert self.structure is not None
            rank = self.structure.rank
            parts: tuple[Floats, ...] = (shared.A, *shared.decomposition)
            if self._last is not None and self._last[0] == rank:
                parts = tuple(np.concatenate(pair) for pair in zip(self._last[1], parts, strict=True))
            self._last = rank, tuple(part[-1:].copy() for part in parts)
            crossed = rank_changes(parts[0], parts[1:], rank)[-samples:]
        left = tau - einsum("nki,nk->ni", loops.J, multipliers)
        left = left - einsum("nki,nk->ni", contacts.J, forces.reshape(samples, -1))
        own, others = loop_wrenches(plan, loops, multipliers)
        whole, at = [own], 0
        for contact in plan.scene.contacts:  # about the middle of its points
            k = slice(at, at + len(contact.points))
            whole += [forces[:, k].sum(axis=1), np.cross(contacts.arms[:, k], forces[:, k]).sum(axis=1)]
            at = k.stop
        wrenches = np.hstack((*whole, others))
        largest = np.abs(tau).max(axis=1, initial=0.0)[:, None]
        small = np.maximum(BALANCED * largest, ROUNDING * self._weight / self._units)
        left = np.where((np.abs(left) <= small) & self.actuation.passive, 0.0, left)
        return Found(wrenches, left, singular, crossed, loops.error, forces, contacts, problem, solved)

    def _shared(self, loops: LoopJacobian, tau: Floats) -> TorqueDistribution:
        """Return the loops' multipliers of least torque. Samples that hold more than all before decide the ranks anew:
        those by which they were decided lay at a singular place, as of a robot that rests there first."""
        assert self.structure is not None
        counted, part = self.actuation.counted, self.actuation
        J = loops.J[:, :, counted]
        found = torque_distribution(self.structure, J, tau[:, counted], part.weights)
        more = found.higher | (found.smallest * GOOD > self.structure.usual)
        self.raised = bool(found.higher.any())
        if more.any():
            self._set_structure(loops, np.flatnonzero(more))
            found = torque_distribution(self.structure, J, tau[:, counted], part.weights)
        return found

    def _decide(self, loops: LoopJacobian, contacts: Floats, touching: Mask) -> None:
        """Decide the ranks of loops once, and which torques are open for each set of points that touch."""
        part, counted = self.actuation, self.actuation.counted
        if self.structure is None:
            self._set_structure(loops, np.arange(len(loops.J)))
        if contacts.shape[1]:
            patterns, first = np.unique(touching, axis=0, return_index=True)
            for pattern, row in zip(patterns, first, strict=True):
                if pattern.tobytes() not in self._patterns:
                    self._patterns.add(pattern.tobytes())
                    J = np.concatenate((loops.J[row], contacts[row][np.repeat(pattern, 3)]))[None, :, counted]
                    self.open_drives |= ~structure(J, part.passive[counted]).torque_determined

    def _set_structure(self, loops: LoopJacobian, rows: NDArray[np.int64]) -> None:
        part = self.actuation
        rows = rows[np.unique(np.linspace(0, len(rows) - 1, REFERENCES).astype(int))]
        units = np.array([equation.unit for each in closures(self.plan) for equation in each.equations])
        gap, size = (np.abs(x[rows]) for x in (loops.error, loops.J))
        # how far loops are open, in rad, and in m of the lengths by which rates move their points
        turns, shifts = (gap[:, units == unit].max(initial=0.0) for unit in ("rad", "m"))
        noise = max(turns, shifts / (size[:, units == "m"].max(initial=0.0) or 1.0))
        self.structure = structure(loops.J[rows][:, :, part.counted], part.passive[part.counted], float(noise))
        if not self.plan.scene.contacts:
            self.open_drives = ~self.structure.torque_determined

    def _problem(self, loops: LoopJacobian, contacts: ContactJacobian, tau: Floats, touching: Mask) -> Problem:
        """Return what contact forces have to do: balance what is passive, its moments in units of the robot's reach."""
        scene, part, unit, weight = self.plan.scene, self.actuation, self._units, self._weight
        P, A, cost = part.passive, part.driven, scene.contact_cost
        balanced = np.abs(tau * unit)
        rounding = ROUNDING * np.maximum(weight, balanced.max(axis=1, initial=0.0))[:, None]
        torques, free = None, None
        if cost.torques or cost.within_limits:
            weights = cost.torques * weight**2 / cost.forces / part.limits**2
            limits = part.limits if cost.within_limits else None
            torques = TorqueTerms(tau[:, A], contacts.J[:, :, A].transpose(0, 2, 1), weights, limits)
        if scene.loops:
            S = loops.J[:, :, A].transpose(0, 2, 1) if torques is not None else None
            free = FreeTerms((loops.J * unit)[:, :, P].transpose(0, 2, 1), S)
        return Problem(
            (contacts.J * unit)[:, :, P].transpose(0, 2, 1),
            np.where(balanced <= rounding, 0.0, tau * unit)[:, P],
            np.array([normal_of(contact, scene) for contact in scene.contacts for _ in contact.points]),
            np.array([contact.friction for contact in scene.contacts for _ in contact.points]),
            touching,
            torques=torques,
            free=free,
        )


class ConstrainedForces(NamedTuple):
    """What the drives, loops and contacts of a robot bear.

    tau: (..., n) of the drives [N m or N], 0 at passive rates but for what nothing gives; wrenches: by name (..., 6)
    force [N] and moment [N m] on its link, of a loop at its point in the axes of the other link, of a contact at the
    middle of its points in the axes of the ground.
    """

    tau: Floats
    wrenches: Mapping[str, Floats]


def constraint_forces(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    *,
    scene: Scene,
    columns: Mapping[str, ArrayLike] | None = None,
    executor: str = "auto",
    threads: int | None = None,
) -> ConstrainedForces:
    """Return torques of the drives, and the forces of loops and contacts, that a motion takes.

    `S_a tau_a + J^T x = M qdd + b`, solved for the torques of the joints that drive and the forces x of loops and
    contacts; see docs/explanation/constraints.md for what is taken where they are open.

    Args:
        model, executor, threads: as for `inverse_dynamics`.
        q, qd, qdd: (..., nq), (..., n), (..., n); all coordinates, on the loops.
        columns: (...) values of the columns that the scene's wrenches and contacts name.

    Raises:
        InputError: as `inverse_dynamics`; a number is not finite; a loop is open by more than 1e-3 rad, m or of its
            size; a contact is on by intervals of time.

    Accuracy: 1e-10 of the largest torque, where the loops are not nearly singular.
    """
    tau, wrenches = _solved(model, {"q": q, "qd": qd, "qdd": qdd}, scene, columns or {}, executor, threads)
    parts = {name: wrenches[..., 6 * i : 6 * i + 6] for i, name in enumerate(scene.constraint_names)}
    return ConstrainedForces(tau, parts)


def as_tree(
    model: Model, state: tuple[ArrayLike, ArrayLike, ArrayLike], scene: Scene, columns: Mapping[str, ArrayLike]
) -> tuple[Scene, dict[str, ArrayLike], Floats]:
    """Return the scene of `tree_scene`, its columns at a state (q, qd, qdd), and (..., n) what that takes at passive
    rates and nothing gives, 0 elsewhere."""
    given = dict(zip(("q", "qd", "qdd"), state, strict=True))
    tau, wrenches = _solved(model, given, scene, columns, "numpy", None)
    found = dict(zip(constraint_columns(scene), np.moveaxis(wrenches, -1, 0), strict=True))
    missing = np.where(actuation(model, scene).passive, tau, 0.0)
    return tree_scene(model, scene), {**columns, **found}, missing


def _solved(
    model: Model,
    given: Mapping[str, ArrayLike],
    scene: Scene,
    columns: Mapping[str, ArrayLike],
    executor: str,
    threads: int | None,
) -> tuple[Floats, Floats]:
    """Return torques (..., n) and wrenches (..., c) by `constraint_columns`."""
    sources, shape = arrays_of(model, given, scene, columns)
    samples = prod(shape)
    for name in given:
        finite = np.isfinite(sources[name]).all(axis=1)
        if not finite.all():
            raise InputError(f"{name} of sample {np.argmin(finite)} is not finite", remedy="leave such samples out")
    on = {}
    for name in (name for name in scene.motion_columns if name in columns):
        values = numbers(name, columns[name], np.dtype(float))
        if np.isnan(values).any():
            what = f"column {shown(name)} of contacts is not a number at {np.isnan(values).sum()} of {values.size}"
            raise InputError(f"{what} samples", remedy="0 where a contact is off, 1 where it is on")
        try:
            on[name] = np.broadcast_to(values, shape).reshape(samples)
        except ValueError:
            what = f"column {shown(name)} of contacts has the shape {values.shape}, the samples {shape}"
            raise InputError(what, remedy="give one value for each sample") from None
    runner = torque_runner(model, open_scene(scene), zero_sources(sources))
    open_tau = runner.run(sources, samples, executor=executor, threads=threads).values
    q, qd = np.ascontiguousarray(sources["q"]), np.ascontiguousarray(sources["qd"])
    solver = ConstraintSolver(plan(model, scene), executor)
    tau, wrenches = np.empty((samples, model.n)), np.empty((samples, len(constraint_columns(scene))))
    for k in solver.pieces(samples):
        here = {name: values[k] for name, values in on.items()}
        found = solver.solve(q[k], qd[k], open_tau[k], touching(solver.plan, q[k], qd[k], None, here, executor))
        _check_closed(solver.plan, found.gap)
        tau[k], wrenches[k] = found.tau, found.wrenches
    return tau.reshape(*shape, model.n), wrenches.reshape(*shape, wrenches.shape[1])


def _check_closed(a_plan: Plan, gap: Floats) -> None:
    """Raise if a loop is open; gap: (N, m) phi of the loops' equations."""
    if not gap.size:
        return
    found = closures(a_plan)
    equations = [(each.loop.name, equation.unit) for each in found for equation in each.equations]
    size = min(1.0, loops_size(a_plan.model, found))
    shares = np.abs(gap).max(axis=0) / [size if unit == "m" else 1.0 for _, unit in equations]
    worst = int(shares.argmax())
    if shares[worst] > CLOSED:
        name, unit = equations[worst]
        what = f"loop {shown(name)} is open by {np.abs(gap[:, worst]).max():.3g} {unit}"
        remedy = "give coordinates that close it; robodyn.torques finds them from those of the drives"
        raise InputError(what, remedy=remedy)
