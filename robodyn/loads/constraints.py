"""Blocks of a motion under constraints: forces of loops and contacts, given to each block as columns of wrenches, and
the figures that are gathered of them: loops, passive joints, ranks, contacts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from operator import itemgetter

import numpy as np

from robodyn.dynamics.arrays import zero_sources
from robodyn.dynamics.constraints.constraint_jacobian import (
    closures,
    constraint_columns,
    loop_jacobian,
    normal_of,
    open_scene,
    tree_scene,
)
from robodyn.dynamics.constraints.solve import ConstraintSolver, Found, touching
from robodyn.dynamics.constraints.torque_distribution import Mask
from robodyn.dynamics.contacts.solve import centre_of_pressure, friction_used, kinds, least_friction
from robodyn.dynamics.initial_state import independent_equations
from robodyn.dynamics.inverse import mass_matrix
from robodyn.dynamics.loops.closed_chain import NOTHING as LOST
from robodyn.dynamics.loops.position_continuation import Follow
from robodyn.dynamics.plan import Plan, plan, torque_runner
from robodyn.loads.constraint_result import Constraints, ContactLoad, LoopLoad, Missing, Peak, Unbalanced
from robodyn.loads.statistics import Greatest, Integrals
from robodyn.programs.vectors import length, product
from robodyn.robot.model import Model
from robodyn.scene.scene import Contact, Scene, Vector
from robodyn.support.floats import Floats, einsum, steady
from robodyn.support.linear import min_norm_solution, null_space
from robodyn.trajectory.motion import Sampling, Trajectory
from robodyn.trajectory.read import sources_of

MOST_SPANS = 20  # spans without contact forces that are told one by one
ROUNDING = 1e-9  # a smaller distance from an edge [m], or from all of the friction, is none
NOTHING = 1e-9  # of the largest force at any point: a point with less bears nothing but rounding
TOLD = 1e-6  # of the largest torque of the motion: less than that at a passive joint is not told
MOST_PLACES = 20  # singular places that are told one by one


class Follower:
    """Completes the blocks of a motion with loops, one after another; `follow` has the branch chosen, and caveats."""

    def __init__(self, plan: Plan, followed: Sequence[str] = (), file: str | None = None) -> None:
        """Args: followed: joints without columns, each in a loop or refused; file: as messages name it."""
        self.follow = Follow(plan, followed, file)

    def take(self, block: Trajectory) -> Trajectory:
        """Return a block with what follows, accelerations open where any that they come of are; errors: of `Follow`."""
        if not len(block):
            return replace(block, followed=())
        found, branch = block.sampling, self.follow.branch
        bars = () if found is None else (found.off, found.noise)
        whole = self.follow.take(block.given_time, block.q, block.qd, block.qdd, bars, block.first_row)
        if found is not None:
            off, noise = whole.bars
            off_squares, squares = found.off_squares.copy(), found.squares.copy()
            if rates := [*branch.followed]:
                is_open = bool((found.off_squares[branch.given] > 0.0).any())
                off_squares[rates] = (off[:, rates] ** 2).sum(axis=0) if is_open else 0.0
                squares[rates] = (whole.qdd[:, rates] ** 2).sum(axis=0)
            found = Sampling(off, noise, off_squares, squares, found.guessed)
        return replace(block, q=whole.q, qd=whole.qd, qdd=whole.qdd, sampling=found, followed=())


class ConstraintPass:
    """Finds what loops and contacts bear, block by block; tree: the scene in which these act on the open tree;
    followed: (n,) rates told by loops; touching: (N, K) 1 where points of contacts touch, in the last block."""

    def __init__(
        self,
        model: Model,
        scene: Scene,
        executor: str,
        threads: int | None,
        followed: Sequence[str] = (),
        file: str | None = None,
    ) -> None:
        self.model, self.scene, self.tree = model, scene, tree_scene(model, scene)
        self.open, self.executor, self.threads = open_scene(scene), executor, threads
        self.solver = ConstraintSolver(plan(model, scene), executor)
        self.figures = ConstraintFigures(self.solver)
        self.names = tuple(followed)
        self.followed: Mask = np.isin(model.rates, self.names)
        self._follower = Follower(self.solver.plan, followed, file) if scene.loops else None
        self._tau = self._wrenches = self.touching = np.zeros((0, model.n))
        self._lost: Mask = np.zeros(0, dtype=bool)

    def take(self, block: Trajectory) -> Trajectory:
        """Return the block with the coordinates that follow from loops, and the wrenches of its constraints."""
        if (follower := self._follower) is not None:
            block, follow = follower.take(block), follower.follow
            block = replace(block, notes=block.notes + follow.notes, caveats=block.caveats + follow.caveats)
        names = constraint_columns(self.scene)
        self._wrenches, self._tau = np.empty((len(block), len(names))), np.empty((len(block), self.model.n))
        lost = np.zeros(len(block), dtype=bool)
        self.touching = np.zeros((len(block), sum(len(contact.points) for contact in self.scene.contacts)))
        for k, found in self._solved(block, sources_of(block, self.open)):
            self._wrenches[k], self._tau[k], lost[k] = found.wrenches, found.tau, found.singular
            if found.problem is not None and found.problem.active is not None:
                self.touching[k] = found.problem.active
            self.figures.update(block.time[k], block.first_row + k.start, found)
        if lost.any() and not lost.all():
            for column in self._tau.T:  # on straight lines between the samples beside
                column[lost] = np.interp(block.time[lost], block.time[~lost], column[~lost])
        self._lost = lost
        return replace(block, extra={**block.extra, **dict(zip(names, self._wrenches.T, strict=True))})

    def written(self, columns: Floats) -> Floats:
        """Return the columns of `output_names` for the last block, of those (N, n and more) of all rates."""
        n, passive = self.model.n, self.solver.actuation.passive
        own = 6 * len(self.scene.constraint_names)
        return np.hstack((columns[:, :n][:, ~passive], self._wrenches[:, :own], columns[:, n:]))

    @property
    def holds_base(self) -> bool:
        return self.model.floating and not self.scene.contacts and bool(self.solver.actuation.passive[:6].all())

    @property
    def touch(self) -> tuple[Floats, Floats] | None:
        """(C, N) of the last block: what contacts press with along their normals [N], and where they are on."""
        contacts, at = self.scene.contacts, 0
        if not contacts:
            return None
        presses, on = [], []
        for k, contact in enumerate(contacts, start=len(self.scene.loops)):
            presses.append(product(self._wrenches[:, 6 * k : 6 * k + 3], normal_of(contact, self.scene)))
            on.append(self.touching[:, at : at + len(contact.points)].any(axis=1))
            at += len(contact.points)
        return np.array(presses), np.array(on, dtype=float)

    def settle(self, loads: Floats) -> None:
        """Write over what the recursion finds of the last block: at passive rates what nothing gives, no
        wrench at a base that is balanced, and at singular samples the torques of those beside."""
        n, passive = self.model.n, self.solver.actuation.passive
        loads[:, :n][:, passive] = self._tau[:, passive]
        if self.model.floating:
            loads[~self._tau[:, :6].any(axis=1), n : n + 6] = 0.0
        loads[self._lost, :n] = self._tau[self._lost]

    def static(self, block: Trajectory) -> Floats:
        """Return (N, n) the torques that hold a block's poses at rest."""
        rest = {name: np.zeros_like(values) for name, values in (("qd", block.qd), ("qdd", block.qdd))}
        sources = sources_of(block, self.open) | rest
        return np.concatenate([found.tau for _, found in self._solved(block, sources)])

    def _solved(self, block: Trajectory, sources: Mapping[str, Floats]) -> Iterator[tuple[slice, Found]]:
        """Yield parts of a block with what is found there, its motion being that of `sources`."""
        runner = torque_runner(self.model, self.open, zero_sources(sources))
        tau = runner.run(sources, len(block), executor=self.executor, threads=self.threads).values
        q, qd = (np.ascontiguousarray(x) for x in (block.q, block.qd))
        for k in self.solver.pieces(len(block)):
            on = {name: values[k] for name, values in block.extra.items()}
            touch = touching(self.solver.plan, q[k], qd[k], block.time[k], on, self.executor)
            yield k, self.solver.solve(q[k], qd[k], tau[k], touch)

    def response(self, state: Mapping[str, Floats], own: bool = False) -> Floats:
        """Return (n, n) by how much a sample's torques change with each given acceleration, the others following; 0 for
        those that follow. Half the difference of a step forwards and one back, as cones make pieces. state: q (nq,),
        qd, qdd (n,), columns and touching; own: of each with the least others that loops ask for."""
        M = mass_matrix(self.model, np.ascontiguousarray(state["q"]), scene=self.open, executor="numpy")
        sources = {name: state[name][None] for name in ("q", "qd", "qdd")}
        sources["columns"] = state["columns"][None, : len(self.open.columns)]
        tau = torque_runner(self.model, self.open).run(sources, 1, executor="numpy").values
        moved = product(self._along(state["q"]) if own else self._following(state["q"]), M)
        q, qd = (np.repeat(sources[name], 2 * len(moved), axis=0) for name in ("q", "qd"))
        touch = np.repeat(state["touching"][None] != 0.0, len(q), axis=0)
        alone = ConstraintSolver(self.solver.plan, "numpy")
        alone.structure = self.solver.structure
        found = alone.solve(q, qd, np.concatenate((tau + moved, tau - moved)), touch).tau
        return np.asarray(0.5 * (found[: len(moved)] - found[len(moved) :]).T)

    def _along(self, q: Floats) -> Floats:
        """Return (n, n) accelerations, row by row: a unit of each, and the least of the others that loops ask for."""
        if not self.scene.loops:
            return np.eye(self.model.n)
        free = null_space(loop_jacobian(self.solver.plan, q[None], "numpy").J[0], LOST)
        kept = product(free.T, free)
        own = np.diag(kept)
        return np.asarray(np.where(own > LOST, 1.0 / np.where(own > LOST, own, 1.0), 0.0)[:, None] * kept)

    def _following(self, q: Floats) -> Floats:
        """Return (n, n) accelerations, row by row: what a unit of each given one takes along; 0 for followed ones."""
        followed = self.followed
        if not followed.any():
            return np.eye(self.model.n)
        J = loop_jacobian(self.solver.plan, q[None], "numpy").J[0]
        out = np.diag((~followed).astype(float))
        for rate in np.flatnonzero(~followed):
            out[rate, followed] = min_norm_solution(J[:, followed], -J[:, rate], LOST)
        return out

    def report(self) -> Constraints:
        return replace(self.figures.report(), followed=self.names)


class ContactFigures:
    """Gathers what contacts bear. missing: the first spans without contact forces, of `spans` in all. friction: the
    least coefficient so far that suffices; None where none does. beyond: the first time [s] at which forces balance the
    motion, and none that keep the effort limits."""

    def __init__(self, solver: ConstraintSolver) -> None:
        scene = solver.plan.scene
        self.executor = solver.executor
        self.each = [_ContactFigures(contact, normal_of(contact, scene)) for contact in scene.contacts]
        self.missing: list[Missing] = []
        self.spans, self._kind = 0, ""
        self.friction: float | None = 0.0
        self.beyond: float | None = None

    def update(self, time: Floats, row: int, found: Found) -> None:
        problem, solved = found.problem, found.solved
        assert problem is not None
        assert solved is not None
        on_all, at = np.ones(found.forces.shape[:2], dtype=bool), 0
        sizes = np.sqrt((found.forces * found.forces).sum(axis=2, keepdims=True))
        forces = np.where(sizes > NOTHING * sizes.max(axis=1, initial=0.0, keepdims=True), found.forces, 0.0)
        for each in self.each:
            k = slice(at, at + len(each.contact.points))
            on = on_all[:, k] if problem.active is None else problem.active[:, k]
            each.update(time, row, on, forces[:, k], found.contacts.arms[:, k])
            at = k.stop
        beyond = np.flatnonzero(solved.feasible & ~solved.within_limits)
        if len(beyond) and self.beyond is None:
            self.beyond = float(time[beyond[0]])
        if self.friction is not None:
            self.friction = least_friction(problem, self.friction, self.executor)
        lost = np.flatnonzero(~solved.feasible)
        names: dict[int, str] = {}
        if len(lost):
            why = kinds(problem.chosen(lost), solved.chosen(lost), self.executor)
            names = dict(zip(lost.tolist(), why, strict=True))
            if problem.active is not None:
                names |= {i: "fly" for i in names if not problem.active[i].any()}
        for i, now in enumerate(time.tolist()) if names or self._kind else ():
            kind, before, self._kind = names.get(i, ""), self._kind, names.get(i, "")
            self.spans += bool(kind) and kind != before
            if not kind or self.spans > MOST_SPANS:
                continue
            moment, force = (Peak(length(part), now, row + i) for part in (found.tau[i, :3], found.tau[i, 3:6]))
            if kind != before:
                self.missing.append(Missing(kind, now, now, force, moment))
            else:
                last = self.missing[-1]
                most = (max(pair, key=itemgetter(0)) for pair in ((last.force, force), (last.moment, moment)))
                self.missing[-1] = Missing(kind, last.start, now, *most)


class _ContactFigures:
    def __init__(self, contact: Contact, normal: Floats) -> None:
        self.contact, self.normal = contact, normal
        self.samples = self.on = 0
        self.force, self.press, self.least, self.used, self.margin = (Greatest(1) for _ in range(5))
        self.centre: Vector | None = None

    def update(self, time: Floats, row: int, touching: Mask, forces: Floats, arms: Floats) -> None:
        """Take in a piece: touching (N, points); forces and arms from the middle (N, points, 3), in ground's axes."""
        on, total = touching.any(axis=1), forces.sum(axis=1)
        self.samples, self.on = self.samples + len(time), self.on + int(on.sum())
        press, used = product(total, self.normal), friction_used(forces, self.normal, self.contact.friction)
        used = np.where(np.abs(used - 1.0) < ROUNDING, 1.0, np.where(np.isnan(used), 0.0, used))
        figures = {self.force: np.sqrt((total * total).sum(axis=1)), self.press: press, self.least: -press}
        for figure, values in (figures | {self.used: used}).items():
            figure.update(time, row, np.where(on, values, -np.inf)[None])
        if len(self.contact.points) > 2:
            centre, margin = centre_of_pressure(arms, self.normal, forces)
            score = np.where(np.abs(margin) < ROUNDING, 0.0, -margin)
            score = np.where(on & ~np.isnan(margin), score, -np.inf)
            for _, at in self.margin.update(time, row, score[None]):
                x, y, z = centre[at].tolist()
                self.centre = x, y, z

    def report(self) -> ContactLoad:
        contact, nothing, margin = self.contact, Peak(0.0, 0.0, 0), _peak(self.margin, -1.0)
        return ContactLoad(
            name=contact.name,
            link=contact.link,
            points=len(contact.points),
            friction=contact.friction,
            on=self.on / self.samples if self.samples else 0.0,
            force=_peak(self.force) or nothing,
            normal=_peak(self.press) or nothing,
            least_normal=_peak(self.least, -1.0) or nothing,
            friction_used=_peak(self.used),
            margin=margin,
            centre=self.centre if margin else None,
        )


def _peak(found: Greatest, sign: float = 1.0) -> Peak | None:
    if found.score[0] == -np.inf:
        return None
    return Peak(sign * float(found.score[0]) + 0.0, float(found.time[0]), int(found.row[0]))


class ConstraintFigures:
    def __init__(self, solver: ConstraintSolver) -> None:
        self.solver, scene = solver, solver.plan.scene
        self.integrals = Integrals()
        self.loops = Greatest(2 * len(scene.loops))
        self.gaps = np.zeros(len(scene.loops))
        self.contacts = ContactFigures(solver) if scene.contacts else None
        self.passive = Greatest(int(solver.actuation.passive.sum()))
        self.largest = 0.0
        self.singular: list[float] = []
        self._was_singular, self._last_time = False, 0.0
        self._first_time: float | None = None
        # equations that others of their loops imply, where these are left out
        self._dropped = independent_equations(solver.plan).dropped if scene.loops and scene.contacts else ()

    def update(self, time: Floats, row: int, found: Found) -> None:
        """Take in a piece: time (N,) s, the row of the data that it begins with, and what was found."""
        count, singular = len(self.gaps), found.singular
        if count:
            parts = found.wrenches[:, : 6 * count].reshape(len(time), 2 * count, 3)
            loops = np.sqrt(einsum("nki,nki->kn", parts, parts))
            self.loops.update(time, row, loops)
            self.integrals.update(time, {"square": loops * loops})
            of_equations = [k for k, closure in enumerate(closures(self.solver.plan)) for _ in closure.equations]
            np.maximum.at(self.gaps, of_equations, np.abs(found.gap).max(axis=0))
        passive = found.tau[:, self.solver.actuation.passive].T
        if len(passive):
            self.passive.update(time, row, np.abs(passive), value=passive)
        self.largest = max(self.largest, float(np.abs(found.tau).max(initial=0.0)))
        if self.contacts is not None:
            self.contacts.update(time, row, found)
        # Kept is the first time of each span in which loops hold less, and times between samples at which they do.
        # Where samples hold more than all before, the motion began with a span in which they held less.
        if self.solver.raised and self._first_time is not None and not self._was_singular:
            self.singular.insert(0, self._first_time)
            self._was_singular = True
        if self._first_time is None:
            self._first_time = float(time[0])
        was, before = np.append(self._was_singular, singular[:-1]), np.append(self._last_time, time[:-1])
        between = np.where(singular | was, np.nan, before + found.crossed * (time - before))
        times = np.where(singular & ~was, time, between)
        self.singular += steady(times[np.isfinite(times)]).tolist()
        self._was_singular, self._last_time = bool(singular[-1]), float(time[-1])

    def _loops(self) -> Iterator[LoopLoad]:
        if not len(self.gaps):
            return
        structure, found = self.solver.structure, closures(self.solver.plan)
        assert structure is not None
        root = np.sqrt(self.integrals.mean("square", self.loops.score**2)).tolist()
        columns = (self.loops.score.tolist(), self.loops.time.tolist(), self.loops.row.tolist())
        peaks = [Peak(*each) for each in zip(*columns, strict=True)]
        sure = iter(structure.equation_determined.tolist())
        for k, (loop, equations) in enumerate((closure.loop, closure.equations) for closure in found):
            missed = [equation.about for closure, equation in self._dropped if closure.loop.name == loop.name]
            missed += [equation.about for equation in equations if not next(sure)]
            i, j = 2 * k, 2 * k + 1
            sizes = peaks[i], peaks[j], root[i], root[j]
            yield LoopLoad(
                loop.name, loop.link, loop.to, loop.kind, *sizes, not missed, tuple(missed), float(self.gaps[k])
            )

    def report(self) -> Constraints:
        solver, scene = self.solver, self.solver.plan.scene
        assert solver.structure is not None
        shape, part, rates = solver.structure, solver.actuation, np.array(solver.plan.model.rates)
        passive, driven, most = rates[part.passive].tolist(), rates[part.driven].tolist(), self.passive
        slides, unbalanced = {joint.name for joint in solver.plan.model.independent if joint.kind == "prismatic"}, []
        for k in np.flatnonzero(most.score > TOLD * self.largest).tolist():
            unit = "N" if passive[k] in slides or passive[k][-3:] in ("_vx", "_vy", "_vz") else "N m"
            peak = Peak(float(most.kept["value"][k]), float(most.time[k]), int(most.row[k]))
            unbalanced.append(Unbalanced(passive[k], unit, peak))
        determined = dict(zip(driven, (~solver.open_drives).tolist(), strict=True))
        undriven = [] if scene.contacts else [n for n, on in zip(passive, shape.undriven_rates, strict=True) if on]
        count, contacts, share = len(shape.equation_scale), self.contacts, ""
        if not all(determined.values()):
            share = f"the torques with the least {'' if scene.share == 'least' else 'weighted '}sum of squares"
            if contacts:
                least = "cost ([contact_cost])" if scene.contact_cost.torques else "sum of squares"
                share = f"the contact forces with the least {least}"
        return Constraints(
            loops=tuple(self._loops()),
            contacts=tuple(each.report() for each in contacts.each) if contacts else (),
            equations=count + len(self._dropped),
            rank=count - shape.overconstrained,
            freedoms=solver.plan.model.n - count + shape.overconstrained,
            redundancy=shape.redundancy,
            overconstrained=shape.overconstrained + len(self._dropped),
            undriven=tuple(undriven),
            determined=determined,
            share=share,
            unbalanced=tuple(unbalanced),
            missing=tuple(contacts.missing) if contacts else (),
            spans=contacts.spans if contacts else 0,
            singular=tuple(self.singular[:MOST_PLACES]),
            followed=(),
            least_friction=contacts.friction if contacts else None,
            beyond_limits=contacts.beyond if contacts else None,
        )
