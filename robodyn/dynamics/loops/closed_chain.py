"""The equations of a closed chain at one configuration, for any scalar."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.effects import rigid_bodies
from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.effects.motors import mass_entries
from robodyn.dynamics.forward import floating_turns, turned
from robodyn.dynamics.loops.closure import Closure, Equations, held
from robodyn.dynamics.loops.equation import Equation
from robodyn.dynamics.loops.givens_projection import GivensProjection
from robodyn.dynamics.loops.local_coordinates import moved, unit
from robodyn.dynamics.plan import applied, loads
from robodyn.dynamics.recursions.composite_body import Root, composite_body, rates_inward
from robodyn.programs.vectors import Array, Scalar, total, vector
from robodyn.robot.kinematics import Wrench
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats

EXACT = 2.0**-34
"""Softness of accelerations: above what rounding leaves of equations that depend on each other, and no more, because
forces along directions that are about to be lost still count."""
GENTLE = 2.0**-10
"""Softness of corrections: near a configuration at which the equations depend on each other, errors of rounding in the
direction that is lost are left alone, where an exact correction would blow them up."""
CORRECTIONS = 2
"""Of the positions after each step, with one factorisation: each divides their error by the inverse of the step's."""


class Dropped(NamedTuple):
    """An equation that others of its loop imply wherever the robot stands."""

    closure: Closure
    equation: Equation


class Solver(NamedTuple):
    """M = C C^T and C^-1 J^T = Q R.

    With `y = C^T a`, `M a - J^T lambda = f` is `y = C^-1 f + C^-1 J^T lambda`, and `J a = b` is `(C^-1 J^T)^T y = b`.
    """

    root: Root
    least: GivensProjection

    def solve(self, f: Sequence[Scalar], b: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        """a and lambda."""
        y, multipliers = self.least.solve(self.root.inward(f), b)
        return self.root.outward(y), multipliers


@dataclass(frozen=True, eq=False)
class ClosedChain:
    """A model with closures: `M qdd + bias = tau + J^T lambda`, `J qdd = -J' qd`.

    Attributes:
        model: of `aligned`; scene: it has these loops.
        closures: with the equations that are kept; `independent_equations` leaves out those that others imply.
        sizes: by equation, how long its column of C^-1 J^T may be, M being C C^T.
        dropped: the equations that are not kept.
    """

    model: Model
    scene: Scene
    closures: tuple[Closure, ...]
    sizes: tuple[float, ...]
    dropped: tuple[Dropped, ...] = ()

    @property
    def count(self) -> int:
        """Equations."""
        return len(self.sizes)

    def sample(self, q: Sequence[Scalar], qd: Sequence[Scalar] | None = None) -> Sample:
        """Return a sample without accelerations, and without speeds if there are none."""
        nothing = (0.0,) * self.model.n
        return Sample(self.model, tuple(q), nothing if qd is None else tuple(qd), nothing)

    def keeping(self, rows: Collection[int]) -> ClosedChain:
        """Return the chain with these of its equations alone; the others are dropped."""
        closures, dropped, at = [], list(self.dropped), 0
        for closure in self.closures:
            own = list(enumerate(closure.equations, at))
            closures.append(replace(closure, equations=tuple(equation for k, equation in own if k in rows)))
            dropped += [Dropped(closure, equation) for k, equation in own if k not in rows]
            at += len(own)
        sizes = tuple(size for k, size in enumerate(self.sizes) if k in rows)
        return replace(self, closures=tuple(closures), sizes=sizes, dropped=tuple(dropped))

    def equations(self, sample: Sample) -> Equations:
        """Return the equations of all closures, one after another."""
        joints = sample.motions()
        parts: list[tuple[Any, ...]] = [
            held(closure, closure.relative(self.model, joints)) for closure in self.closures
        ]
        return Equations(*([x for part in parts for x in part[k]] for k in range(len(Equations._fields))))

    def jacobian(self, sample: Sample) -> Floats:
        """Return (equations, n) J at a sample of floats."""
        rows = [[row.get(rate, 0.0) for rate in range(self.model.n)] for row in self.equations(sample).J]
        return np.array(rows, dtype=float).reshape(self.count, self.model.n)

    def wrenches(self, here: Equations, multipliers: Iterable[Scalar]) -> Iterator[Wrench]:
        """Yield what the other link of each closure does to its link, at its point, in the axes of the other."""
        left = iter(multipliers)
        for closure, place in zip(self.closures, here.places, strict=True):
            parts = [(equation.force(), equation.moment(place.B), next(left)) for equation in closure.equations]
            f = [total(force[i] * value for force, _, value in parts) for i in range(3)]
            yield Wrench(
                vector(*f), vector(*(total(moment[i] * value for _, moment, value in parts) for i in range(3)))
            )

    def solver(self, sample: Sample, terms: Terms, J: Sequence[dict[int, Scalar]], softness: float) -> Solver:
        """Return what solves `M a - J^T lambda = f`, `J a = b` at a sample.

        Args:
            softness: singular values of C^-1 J^T that are smaller than this part of the largest count for less.

        Raises:
            InputError: nothing resists a joint.
        """
        n = self.model.n
        M = composite_body(self.model, sample.motions(), terms.inertias, mass_entries(sample, self.scene))
        root = Root(M, rates_inward(self.model), self.model.rates)
        columns = [root.inward([row.get(rate, 0.0) for rate in range(n)]) for row in J]
        rows = [{k: column[rate] for k, column in enumerate(columns)} for rate in range(n)]
        return Solver(root, GivensProjection(rows, [softness * size for size in self.sizes]))

    def accelerations(self, sample: Sample, terms: Terms, tau: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        """qdd, and lambda by equation. Errors decay at the Baumgarte rate b: `J qdd = -J' qd - 2 b phi' - b^2 phi`.

        Args:
            sample: of this model; its qdd are zero.
            terms: without acceleration.
            tau: n scalars.
        """
        b, here = self.scene.baumgarte, self.equations(sample)
        free = [torque - other for torque, other in zip(tau, loads(sample, terms).tau, strict=True)]
        rows = zip(here.bias, here.rate, here.error, strict=True)
        wanted = [0.0 - bias - 2.0 * b * rate - b * b * error for bias, rate, error in rows]
        qdd, multipliers = self.solver(sample, terms, here.J, EXACT).solve(
            turned(free, self._floating(sample), back=True), wanted
        )
        return self.along_parents(sample, qdd), multipliers

    def inertial(self, sample: Sample) -> Terms:
        """Return inertias alone."""
        return applied([rigid_bodies.PAYLOAD], sample, self.scene)

    def settled(self, q: Sequence[Scalar], qd: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        """The state on the loops that is nearest in kinetic energy, for any scalar; with Baumgarte's terms, the same.

        `M u - J^T mu = 0`, `J u = -phi` for positions, twice with the J of the first; `J u = -phi'` for speeds.
        """
        if self.scene.baumgarte:
            return list(q), list(qd)
        first = self.sample(q, qd)
        here = self.equations(first)
        solver = self.solver(first, self.inertial(first), here.J, GENTLE)

        def step(errors: Sequence[Scalar]) -> list[Scalar]:
            found, _ = solver.solve([0.0] * self.model.n, [0.0 - error for error in errors])
            return self.along_parents(first, found)

        for _ in range(CORRECTIONS):
            q = unit(self.model, moved(self.model, q, step(here.error)))
            here = self.equations(self.sample(q, qd))
        return list(q), [rate + more for rate, more in zip(qd, step(here.rate), strict=True)]

    def along_parents(self, sample: Sample, rates: Sequence[Scalar]) -> list[Scalar]:
        """Return the rates, those of a floating joint's position turned from its body's axes to its parent's."""
        return turned(rates, self._floating(sample))

    def _floating(self, sample: Sample) -> list[tuple[slice, Array]]:
        free = any(body.joint.kind == "floating" for body in self.model.bodies)
        return floating_turns(self.model, sample.motions()) if free else []
