"""Closed chains in a simulation: states brought back onto their loops after each step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from robodyn.dynamics.effects import payload
from robodyn.dynamics.effects.effect import Sample, Terms
from robodyn.dynamics.loops.closed_chain import ClosedChain
from robodyn.dynamics.loops.find import Dropped, Found
from robodyn.dynamics.loops.turning import moved, unit
from robodyn.dynamics.plan import Plan, applied
from robodyn.programs.vectors import Scalar
from robodyn.robot.model import Model

GENTLE = 2.0**-10
"""Softness of corrections: near a configuration at which the equations depend on each other, errors of rounding in the
direction that is lost are left alone, where an exact correction would blow them up."""
CORRECTIONS = 2
"""Of the positions after each step, with one factorisation: each divides their error by the inverse of the step's."""


@dataclass(frozen=True, eq=False)
class Closing:
    """The loops of a plan.

    Attributes:
        found: their equations; `necessary.closing` leaves out those that others imply.
    """

    plan: Plan
    found: Found

    @property
    def chain(self) -> ClosedChain:
        return self.found.chain

    @property
    def dropped(self) -> tuple[Dropped, ...]:
        return self.found.dropped

    @property
    def model(self) -> Model:
        return self.chain.model

    def sample(self, q: Sequence[Scalar], qd: Sequence[Scalar]) -> Sample:
        return Sample(self.model, tuple(q), tuple(qd), (0.0,) * self.model.n)

    def inertial(self, sample: Sample) -> Terms:
        """Inertias alone."""
        return applied([payload.EFFECT], sample, self.plan.scene)

    def settled(self, q: Sequence[Scalar], qd: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        """The state on the loops that is nearest in kinetic energy, for any scalar; with Baumgarte's terms, the same.

        `M u - J^T mu = 0`, `J u = -phi` for positions, twice with the J of the first; `J u = -phi'` for speeds.
        """
        if self.chain.baumgarte:
            return list(q), list(qd)
        n, first = self.model.n, self.sample(q, qd)
        here = self.chain.equations(first)
        solver = self.chain.solver(first, self.inertial(first), here.J, GENTLE)

        def step(errors: Sequence[Scalar]) -> list[Scalar]:
            found, _ = solver.solve([0.0] * n, [0.0 - error for error in errors])
            return self.chain.along_parents(first, found)

        for _ in range(CORRECTIONS):
            q = unit(self.model, moved(self.model, q, step(here.error)))
            here = self.chain.equations(self.sample(q, qd))
        return list(q), [rate + more for rate, more in zip(qd, step(here.rate), strict=True)]
