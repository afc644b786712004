"""The regressor's base columns and the torques of a sample, and the slope of any sum of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.plan import Plan, loads, runner_of
from robodyn.dynamics.regressor import regressor_program
from robodyn.programs.derivative import again, jacobian
from robodyn.programs.program import trace
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import CONSTANT, Tape
from robodyn.programs.vectors import Scalar
from robodyn.support.floats import Floats

SOURCES = ("q", "qd", "qdd")


class Programs(NamedTuple):
    """What is computed of motions (3, N, n) of q, qd and qdd.

    Attributes:
        n, r: torques, and columns of the regressor.
        shown: for each torque, which of the columns are not zero in its row whatever the motion: in a tree, few.
        rows: these entries of the regressor, one torque after another, and the torques.
        slopes: the derivative of a sum of these, each times a weight of its own, by q, qd and qdd.
    """

    n: int
    r: int
    shown: tuple[tuple[int, ...], ...]
    rows: Runner
    slopes: Runner

    def values(self, motion: Floats) -> tuple[list[Floats], Floats]:
        """Return the rows of each torque (N, c) in the columns that are not zero, and the torques (N, n)."""
        found = np.ascontiguousarray(self.rows(self._sources(motion), motion.shape[1], executor="numpy"))
        *rows, tau = np.split(found, np.cumsum([len(columns) for columns in self.shown]), axis=1)
        return rows, tau

    def slope(self, motion: Floats, of_rows: list[Floats], of_torques: Floats) -> Floats:
        """Return the derivative (3, N, n) of sum of_rows rows + sum of_torques tau by the motion."""
        samples = motion.shape[1]
        weights = np.concatenate((*of_rows, of_torques), axis=1)
        found = self.slopes({**self._sources(motion), "weights": weights}, samples, executor="numpy")
        return np.asarray(found.reshape(samples, 3, self.n).transpose(1, 0, 2))

    def _sources(self, motion: Floats) -> dict[str, Floats]:
        return dict(zip(SOURCES, motion, strict=True))


def programs_of(plan: Plan, columns: Sequence[int], count: int) -> Programs:
    """Return the programs of a plan for some columns of the regressor, of `count` that it has."""
    n, whole = plan.model.n, regressor_program(plan)
    zero = [whole.operations[position] == (CONSTANT, 0.0, None) for position in whole.outputs]
    shown = tuple(tuple(k for k, j in enumerate(columns) if not zero[i * count + j]) for i in range(n))

    def entries(tape: Tape) -> list[Scalar]:
        found = again(whole, tape)
        rows = (found[i * count + columns[k]] for i in range(n) for k in shown[i])
        return [*rows, *loads(*plan.terms(tape)).tau]

    def slopes(tape: Tape) -> Iterable[Scalar]:
        terms = (entry * tape.input("weights", k) for k, entry in enumerate(entries(tape)))
        inputs = [tape.input(source, k) for source in SOURCES for k in range(n)]
        return jacobian([sum(terms, 0.0)], [{each: 1.0} for each in inputs])[0]

    weights = {"weights": sum(map(len, shown)) + n}
    return Programs(n, len(columns), shown, runner_of(trace(entries), plan), runner_of(trace(slopes), plan, weights))
