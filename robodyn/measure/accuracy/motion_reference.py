"""Motions to measure others by, with a bound of their own error: that of two which were found independently."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.initial_state import initial_state
from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError
from robodyn.measure.accuracy.motion_error import MotionError, between_records
from robodyn.measure.accuracy.taylor import BITS, Taylor, fixed, step_of, summed
from robodyn.robot.configuration import unit_rows
from robodyn.robot.model import Model
from robodyn.simulation.equations import STATE, Equations
from robodyn.simulation.result import Simulation
from robodyn.simulation.run import simulate
from robodyn.support.floats import Floats

Run = Callable[..., Simulation]
"""`simulate` with all but the duration and the method."""
COARSE, FINE = (16, 1e-18), (24, 1e-22)
"""Orders of series and their tolerances."""
PATIENCE = 10.0
"""Seconds for a series; motions that need more are measured by two methods in doubles."""
MOST = 2e5
"""Evaluations of an adaptive method, after which another one is tried."""
CHECKED = 200
"""Times at which two motions are compared, at most."""


@dataclass(frozen=True, eq=False)
class Reference:
    """A motion that is known to a bound.

    Attributes:
        at: states (N, nq + n) at times (N,).
        error: measures other states.
        bound, bound_at_end: of the error of `at`, anywhere and at the end, measured like those.
        how: it was found, in words.
    """

    at: Callable[[Floats], Floats]
    error: MotionError
    bound: float
    bound_at_end: float
    how: str


def motion_reference(plan: Plan, duration: float, run: Run | None = None) -> Reference:
    """Return the motion of a plan's robot from its scene's initial state; joint limits are not looked at.

    By power series in 77 digits, of two orders with tolerances of their own, where that takes seconds; else, and for
    tables and closed chains, by DOP853 (or Radau) and by a Gauss-Legendre method of order 6 (or RK4), in doubles.
    The bound is the largest difference of the two.

    Args:
        run: simulates it, where that needs more than the plan: a table.

    Raises:
        InputError: mpmath is not installed, or no method gets through.
    """
    times = np.linspace(0.0, duration, CHECKED)
    try:
        coarse, fine = (_series(plan, duration, *how) for how in (COARSE, FINE))
    except (InputError, ZeroDivisionError, ValueError, OverflowError):
        return _in_doubles(plan.model, duration, run or partial(simulate, plan.model, plan.scene))
    expected = fine(times)
    measure = MotionError.over(plan.model, expected)
    apart = measure(coarse(times), expected) + np.finfo(float).eps
    how = f"power series of orders {COARSE[0]} and {FINE[0]} in 77 digits"
    return _bounded(fine, measure, apart, how)


def _bounded(at: Callable[[Floats], Floats], measure: MotionError, apart: Floats, how: str) -> Reference:
    """Args: apart: how far two motions are from each other at some times, the last of which is the end."""
    bound, end = float(apart.max()), float(apart[-1])
    ends = f" ({end:.0e} at the end)" if end < 0.1 * bound else ""
    return Reference(at, measure, bound, end, f"{how}, which agree to {bound:.0e}{ends}")


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


def _in_doubles(model: Model, duration: float, run: Run) -> Reference:
    """By two methods in doubles, each the first of its kind that gets through."""
    halved = [("gauss6", 16), ("gauss6", 14), ("gauss6", 18), ("rk4", 17)]
    fine = _first(run, duration, [(name, {"step": duration / 2**k}) for name, k in halved])
    other = _first(run, duration, [("dop853", {"rtol": 1e-13, "most": MOST}), ("radau", {"rtol": 1e-11, "most": MOST})])
    at = between_records(fine)
    some = np.unique(np.linspace(0, len(other.time) - 1, CHECKED).astype(int))
    found = np.hstack((other.q, other.qd))[some]
    measure = MotionError.over(model, found)
    apart = measure(at(other.time[some]), found) + np.finfo(float).eps
    return _bounded(at, measure, apart, f"{fine.method.name} and {other.method.name}")


def _first(run: Run, duration: float, ways: list[tuple[str, dict[str, Any]]]) -> Simulation:
    """Return the first of some simulations that gets through."""
    problem: InputError | None = None
    for method, how in ways:
        try:
            return run(duration, method=method, **how)
        except InputError as error:
            problem = error
    assert problem is not None
    raise InputError(f"no reference: {problem.what}", remedy="give a shorter --duration, or a softer friction or drive")
