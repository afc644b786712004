"""One step of a Runge-Kutta method as programs: from a state to the next, rotations by the exponential map."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property

from robodyn.dynamics.loops.closure import moved, unit
from robodyn.programs.program import Program, trace
from robodyn.programs.run.stepper import COLUMNS
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar
from robodyn.simulation.equations import STATE, Equations, Given, Rates, State
from robodyn.simulation.methods import Method

REST = 2.0**-16
"""Times the square of positions (and 1) per step; what is left of that in a step is less than their rounding."""


class Steps:
    """The programs of a method for the equations of a robot. Both read and write a state and its stages.

    Of an implicit method the stages `K_i` (rates of u, qd and work) follow the state: `sweep` puts
    `f(y + h sum_j A_ij K_j)` in place of every K_i, again and again until they stay, and tells their change; `step`
    then ends the step and keeps them as a guess for the next one. Of an explicit one there are no stages to keep.
    The change is relative to the stages, or to a small part of positions per step: where forces cancel, a robot at
    rest has no stages to speak of.

    Attributes:
        width: numbers that both programs read, and write but for the change.
        columns: numbers that both read for each step of a motion with curves: these at every moment of the method, and
            the length of the step, which the state keeps where there are none.
    """

    def __init__(self, equations: Equations, method: Method) -> None:
        self.equations, self.method = equations, method
        stages, curves = len(method.b) if method.implicit else 0, len(equations.curves)
        self.width = equations.width + stages * (2 * equations.model.n + 1)
        self.columns = curves * len(method.moments) + 1 if curves else 0

    @cached_property
    def step(self) -> Program:
        """The program of the state (and stages) after a step."""

        def outputs(tape: Tape) -> Iterable[Scalar]:
            state, given = self._state(tape), self._curves(tape)
            if self.method.leapfrog:
                return self._leap(state, given[0])
            if self.method.implicit:
                stages = self._stages(tape)
                return [*self._end(state, stages), *_flat(stages)]
            stages = []
            for row, now in zip(self.method.A, given, strict=True):
                stages.append(self._stage(state, stages, row[: len(stages)], now))
            return self._end(state, stages)

        return trace(outputs)

    @cached_property
    def sweep(self) -> Program | None:
        """The program of the state, the stages after a sweep and the square of their change; None if explicit."""
        if not self.method.implicit:
            return None

        def outputs(tape: Tape) -> Iterable[Scalar]:
            state, old, given = self._state(tape), self._stages(tape), self._curves(tape)
            new = [self._stage(state, old, row, now) for row, now in zip(self.method.A, given, strict=True)]
            before, after = _flat(old), _flat(new)
            change = _square(a - b for a, b in zip(after, before, strict=True))
            floor = (REST + REST * _square(state.q)) / (state.step * state.step)
            return [*state.q, *state.qd, state.work, state.step, *after, change / (_square(after) + floor)]

        return trace(outputs)

    def _state(self, tape: Tape) -> State:
        state = self.equations.state(tape)
        return state._replace(step=tape.input(COLUMNS, self.columns - 1)) if self.columns else state

    def _curves(self, tape: Tape) -> list[Given]:
        moments = self.method.moments
        return [self.equations.given(tape, moments.index(node)) for node in self.method.nodes]

    def _stages(self, tape: Tape) -> list[Rates]:
        """The stages that a program is given."""
        n, at = self.equations.model.n, self.equations.width
        stages = []
        for first in range(at, at + len(self.method.b) * (2 * n + 1), 2 * n + 1):
            values = [tape.input(STATE, first + k) for k in range(2 * n + 1)]
            stages.append(Rates(values[:n], values[n:-1], values[-1]))
        return stages

    def _stage(self, state: State, stages: Sequence[Rates], row: Sequence[float], given: Given) -> Rates:
        """The rates at `y + h sum_j row_j K_j`."""
        h, n = state.step, self.equations.model.n
        u = [h * total for total in _sums(row, [K.u for K in stages], n)]
        gains = _sums(row, [K.qd for K in stages], n)
        return self.equations.rates(state.q, u, [x + h * gain for x, gain in zip(state.qd, gains, strict=True)], given)

    def _leap(self, state: State, given: Given) -> list[Scalar]:
        """The state after half a step at the old speed, a whole one of acceleration and half a step at the new speed.

        Work is done at the mean of both speeds.
        """
        h, equations, half = state.step, self.equations, [0.5 * state.step * x for x in state.qd]
        qdd = equations.rates(state.q, half, [0.0] * len(half), given).qd
        mean = [x + 0.5 * h * a for x, a in zip(state.qd, qdd, strict=True)]
        qd = [x + h * a for x, a in zip(state.qd, qdd, strict=True)]
        power = equations.rates(state.q, half, mean, given).work
        u = [h * x for x in mean]
        return [*unit(equations.model, moved(equations.model, state.q, u)), *qd, state.work + h * power, h]

    def _end(self, state: State, stages: Sequence[Rates]) -> list[Scalar]:
        h, b, model = state.step, self.method.b, self.equations.model
        gains = _sums(b, [K.qd for K in stages], model.n)
        qd = [x + h * gain for x, gain in zip(state.qd, gains, strict=True)]
        u = [h * total for total in (qd if self.method.semi else _sums(b, [K.u for K in stages], model.n))]
        work = _sums(b, [[K.work] for K in stages], 1)[0]
        q, qd = self.equations.settled(moved(model, state.q, u), qd)
        if self.method.keeps_momenta:
            qd = self.equations.with_momenta(state, q, qd)
        return [*q, *qd, state.work + h * work, h]


def _flat(stages: Iterable[Rates]) -> list[Scalar]:
    return [x for K in stages for x in (*K.u, *K.qd, K.work)]


def _square(values: Iterable[Scalar]) -> Scalar:
    total: Scalar = 0.0
    for x in values:
        total = total + x * x
    return total


def _sums(weights: Sequence[float], stages: Sequence[Sequence[Scalar]], n: int) -> list[Scalar]:
    totals: list[Scalar] = [0.0] * n
    for weight, values in zip(weights, stages, strict=True):
        if weight:
            totals = [total + weight * value for total, value in zip(totals, values, strict=True)]
    return totals
