"""Methods in order of what they cost: true errors, times measured in turn, and which of them are worth their time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from robodyn.errors import InputError

SPREAD_BUDGET, SPREAD_ROUNDS = 1.0, 5
"""Seconds for which rounds are repeated; so many at least, and at most 200 times as many."""
SLOW, CACHED = 0.5, 0.01  # seconds from which one run has to do, and below which what stands in the caches matters
ROUNDING = 2.0**-53  # of a result to a float


@dataclass(frozen=True)
class Spread:
    """Times of several runs: the median, and the quartiles `low` and `high`."""

    median: float
    low: float
    high: float
    runs: int

    @classmethod
    def of(cls, times: list[float], share: float = 1.0) -> Spread:
        low, median, high = np.quantile(times, (0.25, 0.5, 0.75)).tolist()
        return cls(median * share, low * share, high * share, len(times))


def timed(acts: Mapping[str, Callable[[], Any]], share: float = 1.0) -> dict[str, tuple[Any, Spread]]:
    """Return what each act returns and how long it takes, a share of which counts.

    Acts take turns, so that all meet the same load of the machine; a first run counts for slow acts alone, and of short
    ones each second run, with its code and data in the caches."""
    results = {name: _run(act) for name, act in acts.items()}
    first = {name: took for name, (_, took) in results.items()}
    spent: dict[str, list[float]] = {name: [] for name in acts if first[name] < SLOW}
    start, rounds = perf_counter(), 0
    while rounds < SPREAD_ROUNDS or (perf_counter() - start < SPREAD_BUDGET and rounds < 200 * SPREAD_ROUNDS):
        for name, times in spent.items():
            if first[name] < CACHED:
                acts[name]()
            times.append(_run(acts[name])[1])
        rounds += 1
    return {name: (found, Spread.of(spent.get(name) or [took], share)) for name, (found, took) in results.items()}


def _run(act: Callable[[], Any]) -> tuple[Any, float]:
    begin = perf_counter()
    result = act()
    return result, perf_counter() - begin


def refuse_beyond_doubles(target: float) -> None:
    """Raise InputError if no result in doubles can be that accurate."""
    if target < ROUNDING:
        what = f"an accuracy of {target:g} cannot be promised: results are doubles, which are rounded to {ROUNDING:.1e}"
        raise InputError(what, remedy=f"ask for {ROUNDING:.1e} or more")


@dataclass(frozen=True)
class Rung:
    """One method. errors: true relative errors, one for each of the ladder's `measures`; time: seconds. operations:
    floating-point operations, None where they are not counted. evaluations: of the equations of motion; drift: of the
    energy along a motion, relative to the largest kinetic energy; None where there is none."""

    name: str
    errors: tuple[float, ...]
    time: Spread
    operations: float | None = None
    evaluations: int | None = None
    drift: float | None = None

    @property
    def error(self) -> float:
        return max(self.errors)


@dataclass(frozen=True)
class Price:
    """What something costs that changes no digit of the result [s]."""

    name: str
    time: Spread


@dataclass(frozen=True)
class EffectPrice:
    """What leaving an effect out costs, its largest torque at any joint, and saves: operations per sample."""

    name: str
    torque: float
    unit: str
    joint: str
    saved: int


@dataclass(frozen=True)
class Ladder:
    """Methods for one task: what errors are of and were measured against, what times and operations are for."""

    title: str
    measures: tuple[str, ...]
    reference: str
    per: str
    rungs: tuple[Rung, ...]

    @property
    def front(self) -> tuple[Rung, ...]:
        """The rungs that no other dominates, by time; the error falls from each to the next."""
        found: list[Rung] = []
        for rung in sorted(self.rungs, key=lambda rung: (rung.time.median, rung.error)):
            if not found or rung.error < found[-1].error:
                found.append(rung)
        return tuple(found)

    def dominator(self, rung: Rung) -> Rung | None:
        """The cheapest rung of the front that is neither slower nor less accurate; None if the rung is on the front."""
        best = self.front
        if rung in best:
            return None
        return next(other for other in best if other.time.median <= rung.time.median and other.error <= rung.error)

    def cheapest(self, target: float) -> Rung | None:
        """Return the quickest rung whose errors are all within the target; None if there is none."""
        return next((rung for rung in self.front if rung.error <= target), None)


@dataclass(frozen=True)
class Accuracy:
    """What accuracy costs in time, with prices of what makes a result trustworthy or ready, and of effects."""

    name: str
    ladders: tuple[Ladder, ...]
    prices: tuple[Price, ...]
    effects: tuple[EffectPrice, ...] = ()
    notes: tuple[str, ...] = ()
