"""The equations of a closed chain at one configuration, for any scalar."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from robodyn.dynamics.effects import rigid_bodies
from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.effects.motors import mass_entries
from robodyn.dynamics.loops.closure import GROUND_FRAME, Closure, Equation, Equations, equations_of, held, moved, unit
from robodyn.dynamics.plan import Plan, applied, loads
from robodyn.dynamics.recursions.articulated_body import (
    Root,
    aligned,
    composite_body,
    floating_turns,
    known_zero,
    rates_inward,
    turned,
)
from robodyn.programs.vectors import Scalar, product, sqrt, total, vector
from robodyn.robot.kinematics import Wrench, unit_rows
from robodyn.robot.model import Model
from robodyn.scene.scene import GROUND, Loop, Scene
from robodyn.support.floats import Floats

Rows = list[dict[int, Scalar]]
"""A by its rows: entries by column; those left out are zero."""
NUDGE = 1e-150
"""Keeps a rotation of nothing against nothing the one by no angle; its square is still a number."""
TRIALS = 6
"""Configurations at which equations are looked at."""
RANGE = 1.0
"""rad or m, by which these lie around q = 0."""
NOTHING = 1e-8
"""A smaller part of the largest is what rounding leaves of nothing, or a hinge that is meant to be parallel."""


class GivensProjection:
    """A = Q R, so far as its entries are not zero; `softness` is by column.

    rotations: (i, k, c, s) of row i of A with row k of R, by ((c, s), (-s, c)).
    """

    def __init__(self, A: Rows, softness: Sequence[float]) -> None:
        self.A = [{k: value for k, value in row.items() if not known_zero(value)} for row in A]
        self.order = self._order(len(softness))
        place = {k: at for at, k in enumerate(self.order)}
        self.R: dict[int, dict[int, Scalar]] = {}
        self.rotations: list[tuple[int, int, Scalar, Scalar]] = []
        filled = [i for i, row in enumerate(self.A) if row]
        for i in sorted(filled, key=lambda i: min(place[k] for k in self.A[i])):
            self._take_in(i, dict(self.A[i]), place)
        self.inverse = {k: R[k] / (R[k] * R[k] + softness[k] ** 2) for k, R in self.R.items()}

    def _order(self, count: int) -> list[int]:
        """Return columns in an order that leaves few entries in R: each time the one that meets the fewest others."""
        meets: dict[int, set[int]] = {k: set() for k in range(count)}
        for row in self.A:
            for k in row:
                meets[k] |= row.keys() - {k}
        order = []
        while meets:
            k = min(meets, key=lambda k: (len(meets[k]), k))
            others = meets.pop(k)
            for j in others:
                meets[j] = (meets[j] | others) - {j, k}
            order.append(k)
        return order

    def _take_in(self, i: int, row: dict[int, Scalar], place: dict[int, int]) -> None:
        """Rotates a row of A into R until it fills a row of R that is empty, or nothing of it is left."""
        while row:
            k = min(row, key=lambda k: place[k])
            if k not in self.R:
                self.R[k] = row
                self.rotations.append((i, k, 0.0, 1.0))
                return
            R, a = self.R[k], row.pop(k)
            top = R[k] + NUDGE
            r = sqrt(top * top + a * a)
            inverse = 1.0 / r
            c, s = top * inverse, a * inverse
            R[k] = r
            for j in sorted((R.keys() | row.keys()) - {k}):
                upper, lower = R.get(j, 0.0), row.get(j, 0.0)
                R[j], row[j] = c * upper + s * lower, c * lower - s * upper
            self.rotations.append((i, k, c, s))

    def solve(self, x: Sequence[Scalar], b: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        """y, and lambda of `y = x + A lambda`."""
        z = list(b)
        for i, row in enumerate(self.A):
            for k, value in row.items():
                z[k] = z[k] - value * x[i]
        for k in self.order:
            z[k] = z[k] * self.inverse.get(k, 0.0)
            for j, value in self.R.get(k, {}).items():
                if j != k:
                    z[j] = z[j] - value * z[k]
        change: list[Scalar] = [0.0] * len(x)
        turned = list(z)
        for i, k, c, s in reversed(self.rotations):
            turned[k], change[i] = c * turned[k] - s * change[i], s * turned[k] + c * change[i]
        for k in reversed(self.order):
            rest = total(value * z[j] for j, value in self.R.get(k, {}).items() if j != k)
            z[k] = (z[k] - rest) * self.inverse.get(k, 0.0)
        return [old + more for old, more in zip(x, change, strict=True)], z


EXACT = 2.0**-34
"""Softness of accelerations: above what rounding leaves of equations that depend on each other, and no more, because
forces along directions that are about to be lost still count."""
GENTLE = 2.0**-10
"""Softness of corrections: near a configuration at which the equations depend on each other, errors of rounding in the
direction that is lost are left alone, where an exact correction would blow them up."""
CORRECTIONS = 2
"""Of the positions after each step, with one factorisation: each divides their error by the inverse of the step's."""


Solve = Callable[[Sequence[Scalar], Sequence[Scalar]], tuple[list[Scalar], list[Scalar]]]


@dataclass(frozen=True, eq=False)
class ClosedChain:
    """A model of `aligned` with closures: `M qdd + bias = tau + J^T lambda`, `J qdd = -J' qd`. They have the equations
    that are kept; dropped are those that others of their loops imply."""

    model: Model
    scene: Scene
    closures: tuple[Closure, ...]
    dropped: tuple[tuple[Closure, Equation], ...] = ()

    @property
    def count(self) -> int:
        return sum(len(closure.equations) for closure in self.closures)

    @cached_property
    def sizes(self) -> Floats:
        """(equations,) how long columns of C^-1 J^T may be, M being C C^T; InputError where nothing resists a joint."""
        longest = np.zeros(self.count)
        for q in _trials(self.model):
            sample = self.sample(q)
            _, columns = self._columns(sample, self.inertial(sample), self.equations(sample).J)
            longest = np.maximum(longest, np.sqrt([sum(x * x for x in column) for column in columns]))
        return longest

    def resisting(self) -> ClosedChain:
        """This chain; InputError where nothing resists a joint."""
        _ = self.sizes
        return self

    def sample(self, q: Sequence[Scalar], qd: Sequence[Scalar] | None = None) -> Sample:
        nothing = (0.0,) * self.model.n
        return Sample(self.model, tuple(q), nothing if qd is None else tuple(qd), nothing)

    def keeping(self, rows: Collection[int]) -> ClosedChain:
        closures, dropped, at = [], list(self.dropped), 0
        for closure in self.closures:
            own = list(enumerate(closure.equations, at))
            closures.append(replace(closure, equations=tuple(equation for k, equation in own if k in rows)))
            dropped += [(closure, equation) for k, equation in own if k not in rows]
            at += len(own)
        return replace(self, closures=tuple(closures), dropped=tuple(dropped))

    def equations(self, sample: Sample) -> Equations:
        joints = sample.motions()
        parts: list[Any] = [held(closure, closure.relative(self.model, joints)) for closure in self.closures]
        return Equations(*([x for part in parts for x in part[k]] for k in range(len(Equations._fields))))

    def jacobian(self, sample: Sample) -> Floats:
        """(equations, n) J at a sample of floats."""
        rows = [[row.get(rate, 0.0) for rate in range(self.model.n)] for row in self.equations(sample).J]
        return np.array(rows, dtype=float).reshape(self.count, self.model.n)

    def wrenches(self, here: Equations, multipliers: Iterable[Scalar]) -> Iterator[Wrench]:
        """Yield what the other link of each closure does to its link, at its point, in the axes of the other."""
        left = iter(multipliers)
        for closure, place in zip(self.closures, here.places, strict=True):
            parts = [(equation.D, equation.moment(place.B), next(left)) for equation in closure.equations]
            f = vector(*(total(force[i] * value for force, _, value in parts) for i in range(3)))
            yield Wrench(f, vector(*(total(moment[i] * value for _, moment, value in parts) for i in range(3))))

    def solver(self, sample: Sample, terms: Terms, J: Sequence[dict[int, Scalar]], softness: float) -> Solve:
        """Return what finds a and lambda of `M a - J^T lambda = f`, `J a = b` from f and b at a sample; InputError if
        nothing resists a joint.

        With `M = C C^T`, `y = C^T a` and `C^-1 J^T = Q R`, that is `y = C^-1 f + C^-1 J^T lambda` and `(C^-1 J^T)^T y =
        b`. Singular values of C^-1 J^T that are smaller than a part `softness` of the largest count for less.
        """
        root, columns = self._columns(sample, terms, J)
        rows = [dict(enumerate(row)) for row in zip(*columns, strict=True)]
        least = GivensProjection(rows, [softness * size for size in self.sizes.tolist()])
        turns = floating_turns(self.model, sample.motions())

        def solve(f: Sequence[Scalar], b: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
            y, multipliers = least.solve(root.inward(turned(f, turns, back=True)), b)
            return turned(root.outward(y), turns), multipliers

        return solve

    def _columns(self, sample: Sample, terms: Terms, J: Sequence[dict[int, Scalar]]) -> tuple[Root, list[list[Scalar]]]:
        """C, and C^-1 J^T column by column, along the bodies' axes of floating joints."""
        motions = sample.motions()
        M = composite_body(self.model, motions, terms.inertias, mass_entries(sample, self.scene))
        root, turns = Root(M, rates_inward(self.model), self.model.rates), floating_turns(self.model, motions)
        rows = ([row.get(rate, 0.0) for rate in range(self.model.n)] for row in J)
        return root, [root.inward(turned(row, turns, back=True)) for row in rows]

    def accelerations(self, sample: Sample, terms: Terms, tau: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        """qdd, and lambda by equation; the sample and its terms have no accelerations. Errors decay at the Baumgarte
        rate b: `J qdd = -J' qd - 2 b phi' - b^2 phi`."""
        b, here = self.scene.baumgarte, self.equations(sample)
        free = [torque - other for torque, other in zip(tau, loads(sample, terms).tau, strict=True)]
        rows = zip(here.bias, here.rate, here.error, strict=True)
        wanted = [0.0 - bias - 2.0 * b * rate - b * b * error for bias, rate, error in rows]
        return self.solver(sample, terms, here.J, EXACT)(free, wanted)

    def inertial(self, sample: Sample) -> Terms:
        return applied([rigid_bodies.PAYLOAD], sample, self.scene)

    def settled(self, q: Sequence[Scalar], qd: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        """The state on the loops that is nearest in kinetic energy, for any scalar; with Baumgarte's terms, the same.
        `M u - J^T mu = 0`, `J u = -phi` for positions, twice with the J of the first; `J u = -phi'` for speeds."""
        if self.scene.baumgarte:
            return list(q), list(qd)
        first = self.sample(q, qd)
        here = self.equations(first)
        solve = self.solver(first, self.inertial(first), here.J, GENTLE)

        def step(errors: Sequence[Scalar]) -> list[Scalar]:
            return solve([0.0] * self.model.n, [0.0 - error for error in errors])[0]

        for _ in range(CORRECTIONS):
            q = unit(self.model, moved(self.model, q, step(here.error)))
            here = self.equations(self.sample(q, qd))
        return list(q), [rate + more for rate, more in zip(qd, step(here.rate), strict=True)]


@lru_cache(maxsize=16)
def closed_chain(plan: Plan) -> ClosedChain:
    """Return the closed chain of a model in a scene, without equations that others of their loop imply everywhere, such
    as those across the plane of a planar linkage: of the rows of J at configurations drawn at random, side by side, the
    largest are kept one after another, each without what it has in common with those before it."""
    model, scene = aligned(plan.model), plan.scene
    whole = ClosedChain(model, scene, tuple(closure_of(model, loop) for loop in scene.loops))
    rows, at = np.array([whole.jacobian(whole.sample(q)) for q in _trials(model)]), 0
    kept: list[int] = []
    for size in (len(closure.equations) for closure in whole.closures):
        own = rows[:, at : at + size].transpose(1, 0, 2).reshape(size, -1)
        kept += [at + k for k in independent(own)]
        at += size
    return whole.keeping(kept)


def closure_of(model: Model, loop: Loop) -> Closure:
    """Return the loop with all its equations, its chains from the nearest body that carries both links."""
    ends = (
        model.links[loop.link],
        GROUND_FRAME if loop.to == GROUND and GROUND not in model.links else model.links[loop.to],
    )
    paths: list[list[int]] = [[end.body] for end in ends]
    for path in paths:
        while path[0] >= 0:
            path.insert(0, model.parents[path[0]])
    common = sum(1 for i, j in zip(*paths, strict=False) if i == j)
    return Closure(loop, ends, (tuple(paths[0][common:]), tuple(paths[1][common:])), equations_of(loop))


def independent(rows: Floats, nothing: float = NOTHING) -> list[int]:
    """The places of rows that span all but a part `nothing` of them, by elimination with the largest row first."""
    left, found = rows.copy(), []
    smallest = nothing * np.sqrt((rows * rows).sum(axis=1).max(initial=0.0))
    for _ in rows:
        sizes = np.sqrt((left * left).sum(axis=1))
        k = int(np.argmax(sizes * (1.0 - NOTHING * np.arange(len(rows)))))
        if sizes[k] <= smallest:
            break
        found.append(k)
        one = left[k] / sizes[k]
        left -= np.outer(product(left, one), one)
        left[k] = 0.0
    return sorted(found)


def _trials(model: Model) -> list[tuple[float, ...]]:
    drawn = np.random.default_rng(0).uniform(-RANGE, RANGE, (TRIALS, model.nq))
    return [tuple(row.tolist()) for row in unit_rows(model, drawn)]
