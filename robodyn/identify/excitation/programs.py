"""The regressor's base columns and the torques of a sample, and the slope of any sum of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.plan import Plan, loads
from robodyn.dynamics.regressor import regressor_program
from robodyn.dynamics.runners import runner_of
from robodyn.programs.derivative import again, jacobian
from robodyn.programs.program import trace
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar
from robodyn.support.floats import Floats

SOURCES = ("q", "qd", "qdd")


class Programs(NamedTuple):
    """What is computed of motions (3, N, n) of q, qd and qdd.

    Attributes:
        rows: r columns of the regressor, n rows of them, and the n torques.
        slopes: the derivative of a sum of these, each times a weight of its own, by q, qd and qdd.
    """

    n: int
    r: int
    rows: Runner
    slopes: Runner

    def values(self, motion: Floats) -> tuple[Floats, Floats]:
        """Return Y (N, n, r) and tau (N, n)."""
        found = np.ascontiguousarray(self.rows(self._sources(motion), motion.shape[1], executor="numpy"))
        return found[:, : -self.n].reshape(-1, self.n, self.r), found[:, -self.n :]

    def slope(self, motion: Floats, of_rows: Floats, of_torques: Floats) -> Floats:
        """Return the derivative (3, N, n) of sum of_rows Y + sum of_torques tau by the motion."""
        samples = motion.shape[1]
        weights = np.concatenate((of_rows.reshape(samples, -1), of_torques), axis=1)
        found = self.slopes({**self._sources(motion), "weights": weights}, samples, executor="numpy")
        return np.asarray(found.reshape(samples, 3, self.n).transpose(1, 0, 2))

    def _sources(self, motion: Floats) -> dict[str, Floats]:
        return dict(zip(SOURCES, motion, strict=True))


def programs_of(plan: Plan, columns: Sequence[int], count: int) -> Programs:
    """Return the programs of a plan for some columns of the regressor, of `count` that it has."""
    n, whole = plan.model.n, regressor_program(plan)

    def rows(tape: Tape) -> list[Scalar]:
        entries = again(whole, tape)
        return [*(entries[i * count + j] for i in range(n) for j in columns), *loads(*plan.terms(tape)).tau]

    def slopes(tape: Tape) -> Iterable[Scalar]:
        terms = (entry * tape.input("weights", k) for k, entry in enumerate(rows(tape)))
        inputs = [tape.input(source, k) for source in SOURCES for k in range(n)]
        return jacobian([sum(terms, 0.0)], [{each: 1.0} for each in inputs])[0]

    weights = {"weights": n * len(columns) + n}
    return Programs(n, len(columns), runner_of(trace(rows), plan), runner_of(trace(slopes), plan, weights))
