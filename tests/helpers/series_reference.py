"""Motions by power series in 77 digits, of two orders with tolerances of their own, to measure simulations by."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from math import isqrt, log2
from operator import mul
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.initial_state import initial_state
from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError
from robodyn.measure.accuracy.simulation import CHECKED, MotionError, Reference, Run
from robodyn.measure.accuracy.simulation import motion_reference as in_doubles
from robodyn.programs.program import Program
from robodyn.programs.run.multiprecision import context_of
from robodyn.programs.scalar import ADD, CONSTANT, COS, DIV, EXP, INPUT, MUL, NEG, SIGN, SIN, SQRT, SUB
from robodyn.robot.kinematics import unit_rows
from robodyn.simulation.equations import STATE, Equations
from robodyn.simulation.simulate import simulate
from robodyn.support.floats import Floats

BITS = 256
"""After the binary point; 77 decimal digits."""
Term = Callable[[int], None]
Series = list[int]


class Taylor:
    """The series of the solution through a state, to some order.

    Coefficient k of every operation is found from coefficients up to k of its operands.
    """

    def __init__(self, program: Program, source: str, width: int, order: int) -> None:
        """
        Args:
            program: its outputs are the rates of the first columns of its only source, which has `width` columns.

        Raises:
            InputError: mpmath is not installed; or the program has jumps, or other sources.
        """
        if any(name != source for name, _ in program.inputs) or SIGN in program.counts:
            raise InputError("equations with jumps, or that depend on time, have no power series")
        self.order, self.context = order, context_of(BITS * 3 // 10 + 20)
        self._state: list[Series] = [[] for _ in range(width)]
        self._series: list[Series] = []
        self._terms: list[Term] = []
        self._constants: dict[int, int] = {}
        self._lists: list[Series] = list(self._state)
        for op, a, b in program.operations:
            self._add(op, a, b)
        self._rates = [self._series[k] for k in program.outputs]

    def __call__(self, state: Sequence[int]) -> list[Series]:
        """For each number of the state its `order + 1` coefficients."""
        for each in self._lists:
            each.clear()
        for each, value in zip(self._state, state, strict=True):
            each.append(value)
        for k in range(self.order):
            for term in self._terms:
                term(k)
            for each, rate in zip(self._state, self._rates, strict=False):
                each.append(rate[k] // (k + 1))
            for each in self._state[len(self._rates) :]:
                each.append(0)
        return [list(each) for each in self._state]

    def _add(self, op: str, a: Any, b: Any) -> None:
        if op is INPUT:
            self._series.append(self._state[b])
            return
        out: Series = []
        self._lists.append(out)
        if op is CONSTANT:
            value = self._constants[len(self._series)] = fixed(a)
            self._terms.append(lambda k: out.append(0 if k else value))
        else:
            first = self._series[a]
            second = first if b is None else self._series[b]
            self._terms.append(self._term(op, first, second, out))
            if op is MUL and {a, b} & self._constants.keys():
                known = a if a in self._constants else b
                self._terms[-1] = _scaled(self._constants[known], second if known == a else first, out)
        self._series.append(out)

    def _term(self, op: str, a: Series, b: Series, out: Series) -> Term:
        if op in (SIN, COS, EXP):
            return self._transcendent(op, a, out)
        simple: dict[str, Term] = {
            ADD: lambda k: out.append(a[k] + b[k]),
            SUB: lambda k: out.append(a[k] - b[k]),
            NEG: lambda k: out.append(-a[k]),
            MUL: lambda k: out.append(sum(map(mul, a, reversed(b))) >> BITS),
            DIV: lambda k: out.append(((a[k] << BITS) - sum(map(mul, b[1:], reversed(out)))) // b[0]),
            SQRT: lambda k: out.append(
                ((a[k] << BITS) - sum(map(mul, out[1:], reversed(out[1:])))) // (2 * out[0])
                if k
                else isqrt(a[0] << BITS)
            ),
        }
        return simple[op]

    def _transcendent(self, op: str, a: Series, out: Series) -> Term:
        """By `e' = e a'`, `s' = c a'` and `c' = -s a'`."""
        slope: Series = []
        other: Series = out if op is EXP else []
        self._lists += [slope, other]
        sine, cosine = (out, other) if op is SIN else (other, out)

        def term(k: int) -> None:
            if not k:
                self._first(op, a[0], sine, cosine)
                return
            slope.append(k * a[k])
            if op is EXP:
                out.append((sum(map(mul, slope, reversed(out))) >> BITS) // k)
                return
            up, down = (sum(map(mul, slope, reversed(each))) >> BITS for each in (cosine, sine))
            sine.append(up // k)
            cosine.append(-down // k)

        return term

    def _first(self, op: str, angle: int, sine: Series, cosine: Series) -> None:
        number = self.context.ldexp(angle, -BITS)
        if op is EXP:
            cosine.append(self._fixed(self.context.exp(number)))
            return
        c, s = self.context.cos_sin(number)
        sine.append(self._fixed(s))
        cosine.append(self._fixed(c))

    def _fixed(self, number: Any) -> int:
        return int(self.context.ldexp(number, BITS))


def _scaled(factor: int, a: Series, out: Series) -> Term:
    return lambda k: out.append(factor * a[k] >> BITS)


def fixed(number: float) -> int:
    """Return the integer that stands for a float."""
    return int(Fraction(number) * (1 << BITS))


def step_of(series: Sequence[Series], tolerance: float) -> float:
    """Return the step at which the first term left out is about the tolerance [s]; infinite if the series end.

    By the radius of convergence that the later half of the coefficients shows, some of which may be zero.
    """
    order = len(series[0]) - 1
    inverse = 0.0
    for k in range(order // 2, order + 1):
        largest = max(abs(each[k]) for each in series)
        if largest:
            inverse = max(inverse, 2.0 ** ((log2(largest) - BITS) / k))
    return tolerance ** (1.0 / order) / inverse if inverse else float("inf")


def summed(series: Sequence[Series], step: int) -> list[int]:
    """Return the state after a step."""
    ends = []
    for each in series:
        total = 0
        for coefficient in reversed(each):
            total = (total * step >> BITS) + coefficient
        ends.append(total)
    return ends


PATIENCE = 10.0
"""Seconds for a series."""
COARSE, FINE = (16, 1e-18), (24, 1e-22)
"""Orders of series and their tolerances."""


def motion_reference(plan: Plan, duration: float, run: Run | None = None) -> Reference:
    """The motion of a plan's robot from its scene's initial state, with the difference of two series as its bound.

    Where series take long or there are none, as of closed chains and tables, by two methods in doubles.
    """
    try:
        return _by_series(plan, duration)
    except (InputError, ZeroDivisionError, ValueError, OverflowError):
        return in_doubles(plan.model, duration, run or partial(simulate, plan.model, plan.scene))


def _by_series(plan: Plan, duration: float) -> Reference:
    times = np.linspace(0.0, duration, CHECKED)
    coarse, fine = (_series(plan, duration, *how) for how in (COARSE, FINE))
    expected = fine(times)
    measure = MotionError.over(plan.model, expected)
    apart = measure(coarse(times), expected) + np.finfo(float).eps
    return Reference(fine, measure, float(apart.max()), float(apart[-1]), "power series")


class Piece(NamedTuple):
    """A step of a solution by series: from when, and the coefficients (order + 1, width) of its numbers."""

    start: int
    series: Floats


def _series(plan: Plan, duration: float, order: int, tolerance: float) -> Callable[[Floats], Floats]:
    """Return the motion at any times, from pieces that are series.

    Raises:
        InputError: it has no series, or they take more than `PATIENCE`.
    """
    if plan.scene.loops:
        raise InputError("closed chains are set right after each step")
    equations, model = Equations(plan), plan.model
    taylor = Taylor(equations.derivatives(), STATE, equations.width, order)
    state = [fixed(x) for x in initial_state(model, plan.scene)]
    now, end, begun = 0, fixed(duration), perf_counter()
    pieces = []
    while now < end:
        series = taylor(state)
        step = fixed(min(step_of(series, tolerance), duration))
        pieces.append(Piece(now, np.array([[_float(c) for c in each] for each in series[: model.nq + model.n]]).T))
        state, now = summed(series, step), now + step
        spent = perf_counter() - begun
        if step == 0 or spent > PATIENCE or (spent > 0.5 and spent * end > PATIENCE * now):
            raise InputError("series take too long")
    starts = [piece.start for piece in pieces]

    def at(times: Floats) -> Floats:
        rows = []
        for when in map(fixed, times.tolist()):
            piece = pieces[max(int(np.searchsorted(starts, when, "right")) - 1, 0)]
            rows.append(_horner(piece.series, _float(when - piece.start)))
        return unit_rows(model, np.array(rows))

    return at


def _horner(series: Floats, x: float) -> Floats:
    total: Floats = series[-1]
    for coefficients in series[-2::-1]:
        total = total * x + coefficients
    return total


def _float(number: int) -> float:
    return number / (1 << BITS)
