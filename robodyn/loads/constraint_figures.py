"""Figures of a motion under constraints, gathered block by block: loops, passive joints, ranks, contacts."""

from __future__ import annotations

from collections.abc import Iterator
from operator import itemgetter

import numpy as np

from robodyn.dynamics.constraints.constraint_jacobian import closures, normal_of
from robodyn.dynamics.constraints.solve import ConstraintSolver, Found
from robodyn.dynamics.constraints.torque_distribution import Mask
from robodyn.dynamics.contacts.solve import Forces, Problem, centre_of_pressure, friction_used, kinds, least_friction
from robodyn.dynamics.loops.closed_chain import Dropped
from robodyn.dynamics.loops.closed_start import independent_equations
from robodyn.loads.constraint_result import Constraints, ContactLoad, LoopLoad, Missing, Peak, Unbalanced
from robodyn.loads.statistics import Greatest, Integrals
from robodyn.programs.vectors import length, product
from robodyn.scene.scene import Contact, Vector
from robodyn.support.floats import Floats, einsum, steady

MOST_SPANS = 20
"""Spans without contact forces that are told one by one."""
ROUNDING = 1e-9
"""A smaller distance from an edge [m], or from all of the friction, is none."""
NOTHING = 1e-9
"""Of the largest force at any point: a point with less bears nothing but rounding."""


class ContactFigures:
    """Gathers what contacts bear.

    Attributes:
        missing: the first spans without contact forces, of `spans` in all.
        friction: the least coefficient so far that suffices; None where none does.
        beyond: the first time [s] at which forces balance the motion, and none that keep the effort limits.
    """

    def __init__(self, solver: ConstraintSolver) -> None:
        scene = solver.plan.scene
        self.executor = solver.executor
        self.each = [_ContactFigures(contact, normal_of(contact, scene)) for contact in scene.contacts]
        self.missing: list[Missing] = []
        self.spans, self._kind = 0, ""
        self.friction: float | None = 0.0
        self.beyond: float | None = None

    def update(self, time: Floats, row: int, found: Found) -> None:
        """Take in a piece: time (N,) s, the row of the data that it begins with, and what was found."""
        problem, solved = found.problem, found.solved
        assert problem is not None
        assert solved is not None
        touching, at = np.ones(found.forces.shape[:2], dtype=bool), 0
        sizes = np.sqrt((found.forces * found.forces).sum(axis=2, keepdims=True))
        forces = np.where(sizes > NOTHING * sizes.max(axis=1, initial=0.0, keepdims=True), found.forces, 0.0)
        for each in self.each:
            k = slice(at, at + len(each.contact.points))
            on = touching[:, k] if problem.active is None else problem.active[:, k]
            each.update(time, row, on, forces[:, k], found.contacts.arms[:, k])
            at = k.stop
        self._note_missing(time, row, problem, solved, found.tau)
        beyond = np.flatnonzero(solved.feasible & ~solved.within_limits)
        if len(beyond) and self.beyond is None:
            self.beyond = float(time[beyond[0]])
        if self.friction is not None:
            self.friction = least_friction(problem, self.friction, self.executor)

    def _note_missing(self, time: Floats, row: int, problem: Problem, solved: Forces, tau: Floats) -> None:
        """Extend or begin the spans in which no forces balance the motion."""
        lost = np.flatnonzero(~solved.feasible)
        names: dict[int, str] = {}
        if len(lost):
            found = kinds(problem.chosen(lost), solved.chosen(lost), self.executor)
            names = dict(zip(lost.tolist(), found, strict=True))
            if problem.active is not None:
                names |= {i: "fly" for i in names if not problem.active[i].any()}
        for i, now in enumerate(time.tolist()) if names or self._kind else ():
            kind, before, self._kind = names.get(i, ""), self._kind, names.get(i, "")
            self.spans += bool(kind) and kind != before
            if not kind or self.spans > MOST_SPANS:
                continue
            moment, force = (Peak(length(part), now, row + i) for part in (tau[i, :3], tau[i, 3:6]))
            if kind != before:
                self.missing.append(Missing(kind, now, now, force, moment))
            else:
                last = self.missing[-1]
                most = (max(pair, key=itemgetter(0)) for pair in ((last.force, force), (last.moment, moment)))
                self.missing[-1] = Missing(kind, last.start, now, *most)


class _ContactFigures:
    """Gathers what one contact bears while it is on."""

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
    """Return the peak of a quantity, times a sign; None where it never was."""
    if found.score[0] == -np.inf:
        return None
    return Peak(sign * float(found.score[0]) + 0.0, float(found.time[0]), int(found.row[0]))


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
        count = len(self.gaps)
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
        self._note_singular(time, found)
        if self.contacts is not None:
            self.contacts.update(time, row, found)

    def _note_singular(self, time: Floats, found: Found) -> None:
        """Keep the first time of each span in which loops hold less, and times between samples at which they do. Where
        samples hold more than all before, the motion began with a span in which they held less."""
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
        solver, scene = self.solver, self.solver.plan.scene
        assert solver.structure is not None
        shape, part, rates = solver.structure, solver.actuation, np.array(solver.plan.model.rates)
        passive, driven = rates[part.passive].tolist(), rates[part.driven].tolist()
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
