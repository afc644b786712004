"""Figures of a motion under constraints, gathered block by block: loops, passive joints, ranks."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robodyn.dynamics.constraints.constraint_jacobian import closures
from robodyn.dynamics.constraints.solve import ConstraintSolver, Found
from robodyn.dynamics.loops.closed_chain import Dropped
from robodyn.dynamics.loops.closed_start import independent_equations
from robodyn.loads.constraint_result import Constraints, LoopLoad, Peak, Unbalanced
from robodyn.loads.contact_figures import ContactFigures
from robodyn.loads.statistics import Greatest, Integrals
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats, steady
from robodyn.support.sums import einsum

TOLD = 1e-6
"""Of the largest torque of the motion: less than that at a passive joint is not told."""
MOST_PLACES = 20
"""Singular places that are told one by one."""


class ConstraintFigures:
    """Gathers `Constraints`."""

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

    def update(self, time: Floats, row: int, found: Found) -> None:
        """Take in a piece: time (N,) s, the row of the data that it begins with, and what was found."""
        loops = self._loop_sizes(found.wrenches)
        if len(loops):
            self.loops.update(time, row, loops)
            self.integrals.update(time, {"square": loops * loops})
            np.maximum.at(self.gaps, self._loop_of_equations(), np.abs(found.gap).max(axis=0))
        passive = found.tau[:, self.solver.actuation.passive].T
        if len(passive):
            self.passive.update(time, row, np.abs(passive), value=passive)
        self.largest = max(self.largest, float(np.abs(found.tau).max(initial=0.0)))
        self._note_singular(time, found)
        if self.contacts is not None:
            self.contacts.update(time, row, found)

    def _loop_sizes(self, wrenches: Floats) -> Floats:
        """Return (2 L, N) the magnitudes of forces and moments."""
        count = len(self.solver.plan.scene.loops)
        parts = wrenches[:, : 6 * count].reshape(len(wrenches), 2 * count, 3)
        return np.asarray(np.sqrt(einsum("nki,nki->kn", parts, parts)))

    def _loop_of_equations(self) -> list[int]:
        found = closures(self.solver.plan) if self.solver.plan.scene.loops else ()
        return [k for k, closure in enumerate(found) for _ in closure.equations]

    def _note_singular(self, time: Floats, found: Found) -> None:
        """Keep the first time of each span in which loops hold less, and times between samples at which they do.

        Where samples hold more than all before, the motion began with a span in which they held less.
        """
        if self.solver.raised and self._first_time is not None and not self._was_singular:
            self.singular.insert(0, self._first_time)
            self._was_singular = True
        if self._first_time is None:
            self._first_time = float(time[0])
        was = np.append(self._was_singular, found.singular[:-1])
        before = np.append(self._last_time, time[:-1])
        between = np.where(found.singular | was, np.nan, before + found.crossed * (time - before))
        times = np.where(found.singular & ~was, time, between)
        self.singular += steady(times[np.isfinite(times)]).tolist()
        self._was_singular, self._last_time = bool(found.singular[-1]), float(time[-1])

    def _loops(self) -> Iterator[LoopLoad]:
        """Yield what the loops bear."""
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

    def _unbalanced(self, names: list[str]) -> Iterator[Unbalanced]:
        """Yield what nothing gives at passive rates, where it is more than rounding of the motion."""
        model, most = self.solver.plan.model, self.passive
        prismatic = {joint.name for joint in model.independent if joint.kind == "prismatic"}
        for k, name in enumerate(names):
            if most.score[k] > TOLD * self.largest:
                unit = "N" if name in prismatic or name[-3:] in ("_vx", "_vy", "_vz") else "N m"
                value = float(most.kept["value"][k])
                yield Unbalanced(name, unit, Peak(value, float(most.time[k]), int(most.row[k])))

    def report(self) -> Constraints:
        """Return the figures so far."""
        solver, scene = self.solver, self.solver.plan.scene
        assert solver.structure is not None
        shape, part, rates = solver.structure, solver.actuation, np.array(solver.plan.model.rates)
        passive, driven = rates[part.passive].tolist(), rates[part.driven].tolist()
        determined = dict(zip(driven, (~solver.open_drives).tolist(), strict=True))
        undriven = [] if scene.contacts else [n for n, on in zip(passive, shape.undriven_rates, strict=True) if on]
        count, contacts = len(shape.equation_scale), self.contacts
        return Constraints(
            loops=tuple(self._loops()),
            contacts=contacts.report() if contacts else (),
            equations=count + len(self._dropped),
            rank=count - shape.overconstrained,
            freedoms=solver.plan.model.n - count + shape.overconstrained,
            redundancy=shape.redundancy,
            overconstrained=shape.overconstrained + len(self._dropped),
            undriven=tuple(undriven),
            determined=determined,
            share="" if all(determined.values()) else _share_words(scene),
            unbalanced=tuple(self._unbalanced(passive)),
            missing=tuple(contacts.missing) if contacts else (),
            spans=contacts.spans if contacts else 0,
            singular=tuple(self.singular[:MOST_PLACES]),
            followed=(),
            least_friction=contacts.friction if contacts else None,
            beyond_limits=contacts.beyond if contacts else None,
        )

    @property
    def _dropped(self) -> tuple[Dropped, ...]:
        """Equations that others of their loops imply, where these are left out."""
        scene = self.solver.plan.scene
        return independent_equations(self.solver.plan).dropped if scene.loops and scene.contacts else ()


def _share_words(scene: Scene) -> str:
    if scene.contacts:
        squares = "the least cost ([contact_cost])" if scene.contact_cost.torques else "the least sum of squares"
        return f"the contact forces with {squares}"
    return f"the torques with the least {'' if scene.share == 'least' else 'weighted '}sum of squares"
