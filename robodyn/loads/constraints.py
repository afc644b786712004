"""Blocks of a motion under constraints: forces of loops and contacts, given to each block as columns of wrenches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from robodyn.dynamics.arrays import zero_sources
from robodyn.dynamics.constraints.constraint_jacobian import (
    constraint_columns,
    loop_jacobian,
    normal_of,
    open_scene,
    tree_scene,
)
from robodyn.dynamics.constraints.solve import ConstraintSolver, Found, touching
from robodyn.dynamics.constraints.torque_distribution import Mask
from robodyn.dynamics.inverse import mass_matrix
from robodyn.dynamics.loops.closed_chain import NOTHING
from robodyn.dynamics.loops.position_continuation import Follow
from robodyn.dynamics.plan import Plan, plan, torque_runner
from robodyn.loads.constraint_figures import ConstraintFigures
from robodyn.loads.constraint_result import Constraints
from robodyn.programs.linear import min_norm_solution, null_space
from robodyn.programs.vectors import product
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
from robodyn.trajectory.motion import Sampling, Trajectory
from robodyn.trajectory.read import sources_of


class Follower:
    """Completes the blocks of a motion whose scene has loops, one after another; follow: tells which of several
    branches was chosen, and what makes the motion so far doubtful."""

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
    """Finds what loops and contacts bear, block by block.

    Attributes:
        tree: the scene in which these act on the open tree.
        names: joints that follow from the loops; followed: (n,) their rates.
        touching: (N, K) 1 where points of contacts touch, at the samples of the last block.
    """

    def __init__(
        self,
        model: Model,
        scene: Scene,
        executor: str,
        threads: int | None,
        followed: Sequence[str] = (),
        file: str | None = None,
    ) -> None:
        """Args: followed: joints without columns, which loops tell; file: of the motion, as messages name it."""
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
        base = 6 if self.model.floating else 0
        return bool(base and not self.scene.contacts and self.solver.actuation.passive[:base].all())

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
        """Return (n, n) by how much torques change with each acceleration that is given, the others following.

        Of a solution that is linear in pieces, as cones of friction make it, half of the difference between a step
        forwards and one back. Accelerations that follow from the loops are not given: their columns are 0.

        Args:
            state: q (nq,), qd, qdd (n,), columns and touching of one sample.
            own: of each acceleration with the least of all others that loops ask for, whatever is given.
        """
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
        free = null_space(loop_jacobian(self.solver.plan, q[None], "numpy").J[0], NOTHING)
        kept = product(free.T, free)
        own = np.diag(kept)
        return np.asarray(np.where(own > NOTHING, 1.0 / np.where(own > NOTHING, own, 1.0), 0.0)[:, None] * kept)

    def _following(self, q: Floats) -> Floats:
        """Return (n, n) accelerations, row by row: what a unit of each given one takes along; 0 for followed ones."""
        followed = self.followed
        if not followed.any():
            return np.eye(self.model.n)
        J = loop_jacobian(self.solver.plan, q[None], "numpy").J[0]
        out = np.diag((~followed).astype(float))
        for rate in np.flatnonzero(~followed):
            out[rate, followed] = min_norm_solution(J[:, followed], -J[:, rate], NOTHING)
        return out

    def report(self) -> Constraints:
        return replace(self.figures.report(), followed=self.names)
