"""The equations of a closed chain at one configuration, for any scalar."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.loops.closure import Closure, Equations, held
from robodyn.dynamics.loops.equation import Equation
from robodyn.dynamics.loops.least_change import LeastChange
from robodyn.dynamics.plan import loads
from robodyn.dynamics.recursions.composite_body import Root, SingularError, composite_body, rates_inward
from robodyn.errors import InputError
from robodyn.programs.vectors import Array, Scalar, total, vector
from robodyn.robot.model import Joint, Model
from robodyn.robot.motion_types import Wrench

EXACT = 2.0**-34
"""Softness of accelerations: above what rounding leaves of equations that depend on each other, and no more, because
forces along directions that are about to be lost still count."""


class Dropped(NamedTuple):
    """An equation that others of its loop imply wherever the robot stands."""

    closure: Closure
    equation: Equation


class Solver(NamedTuple):
    """M = C C^T and C^-1 J^T = Q R.

    With `y = C^T a`, `M a - J^T lambda = f` is `y = C^-1 f + C^-1 J^T lambda`, and `J a = b` is `(C^-1 J^T)^T y = b`.
    """

    root: Root
    least: LeastChange

    def solve(self, f: Sequence[Scalar], b: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        """a and lambda."""
        y, multipliers = self.least.solve(self.root.inward(f), b)
        return self.root.outward(y), multipliers


@dataclass(frozen=True, eq=False)
class ClosedChain:
    """A model with closures: `M qdd + bias = tau + J^T lambda`, `J qdd = -J' qd`.

    Attributes:
        model: of `aligned`.
        closures: with the equations that are kept.
        rotors: n reflected rotor inertias.
        sizes: by equation, how long its column of C^-1 J^T may be, M being C C^T.
        baumgarte: 1/s; 0 for none.
        dropped: the equations that are not kept.
    """

    model: Model
    closures: tuple[Closure, ...]
    rotors: tuple[float, ...]
    sizes: tuple[float, ...]
    baumgarte: float = 0.0
    dropped: tuple[Dropped, ...] = ()

    @property
    def count(self) -> int:
        """Equations."""
        return len(self.sizes)

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
        try:
            root = Root(
                composite_body(self.model, sample.motions(), terms.inertias, self.rotors), rates_inward(self.model)
            )
        except SingularError as error:
            name = self.model.rates[error.unknown]
            what = f'joint "{name}" moves nothing that has inertia, so its acceleration is not defined'
            raise InputError(
                what, remedy="give a link that it carries mass and inertia, or the joint a rotor"
            ) from None
        columns = [root.inward([row.get(rate, 0.0) for rate in range(n)]) for row in J]
        rows = [{k: column[rate] for k, column in enumerate(columns)} for rate in range(n)]
        return Solver(root, LeastChange(rows, [softness * size for size in self.sizes]))

    def accelerations(self, sample: Sample, terms: Terms, tau: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        """qdd, and lambda by equation. Errors decay at the Baumgarte rate b: `J qdd = -J' qd - 2 b phi' - b^2 phi`.

        Args:
            sample: of this model; its qdd are zero.
            terms: without acceleration.
            tau: n scalars.
        """
        b, here = self.baumgarte, self.equations(sample)
        free = [torque - other for torque, other in zip(tau, loads(sample, terms).tau, strict=True)]
        rows = zip(here.bias, here.rate, here.error, strict=True)
        wanted = [0.0 - bias - 2.0 * b * rate - b * b * error for bias, rate, error in rows]
        qdd, multipliers = self.solver(sample, terms, here.J, EXACT).solve(self._along_bodies(sample, free), wanted)
        return self.along_parents(sample, qdd), multipliers

    def along_parents(self, sample: Sample, rates: Sequence[Scalar]) -> list[Scalar]:
        """Rates, those of a floating joint's position turned from its body's axes to its parent's."""
        out = list(rates)
        for place, turn in self._floating(sample):
            out[place] = turn @ vector(*out[place])
        return out

    def _along_bodies(self, sample: Sample, forces: Sequence[Scalar]) -> list[Scalar]:
        out = list(forces)
        for place, turn in self._floating(sample):
            out[place] = turn.T @ vector(*out[place])
        return out

    def _floating(self, sample: Sample) -> list[tuple[slice, Array]]:
        joints: list[tuple[int, Joint]] = [(i, body.joint) for i, body in enumerate(self.model.bodies)]
        free = [(i, joint) for i, joint in joints if joint.kind == "floating"]
        motions = sample.motions() if free else []
        return [(slice(joint.rate + 3, joint.rate + 6), joint.R.T @ motions[i].R) for i, joint in free]
