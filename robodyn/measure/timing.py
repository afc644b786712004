"""Measuring time on a machine that others use too: methods take turns; and copying memory, to measure against."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from statistics import median
from threading import Thread
from time import perf_counter
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from robodyn.measure.speed.result import Timing

SPREAD_BUDGET = 1.0
"""Seconds for which rounds are repeated."""
SPREAD_ROUNDS = 5
"""So many at least, and at most 200 times as many."""
SLOW = 0.5
"""Seconds from which one run has to do."""

CACHED = 0.01
"""Seconds below which what stands in the caches matters."""


@dataclass(frozen=True)
class Spread:
    """Times of several runs.

    Attributes:
        median, low, high: of all runs, with the quartiles.
        runs: how many.
    """

    median: float
    low: float
    high: float
    runs: int

    @classmethod
    def of(cls, times: list[float], share: float = 1.0) -> Spread:
        """Args: share: of each time that counts, such as one for every sample."""
        low, median, high = np.quantile(times, (0.25, 0.5, 0.75)).tolist()
        return cls(median * share, low * share, high * share, len(times))


def timed(acts: Mapping[str, Callable[[], Any]], share: float = 1.0) -> dict[str, tuple[Any, Spread]]:
    """Return what each act returns and how long it takes.

    They take turns, so that all meet the same load of the machine. The first run, which brings code and data to the
    caches, counts for those alone that are slow; and a short act is run twice in each turn, of which the second counts,
    or it would pay for what the one before it has left in the caches.

    Args:
        share: of each time that counts.
    """
    results: dict[str, Any] = {}
    first: dict[str, float] = {}
    for name, act in acts.items():
        results[name], first[name] = _run(act)
    spent: dict[str, list[float]] = {name: [] for name in acts if first[name] < SLOW}
    start, rounds = perf_counter(), 0
    while rounds < SPREAD_ROUNDS or (perf_counter() - start < SPREAD_BUDGET and rounds < 200 * SPREAD_ROUNDS):
        for name, times in spent.items():
            if first[name] < CACHED:
                acts[name]()
            times.append(_run(acts[name])[1])
        rounds += 1
    return {name: (result, Spread.of(spent.get(name) or [first[name]], share)) for name, result in results.items()}


def _run(act: Callable[[], Any]) -> tuple[Any, float]:
    begin = perf_counter()
    result = act()
    return result, perf_counter() - begin


Key = TypeVar("Key", bound=Hashable)

BUDGET = 0.8
"""Seconds for which rounds are repeated."""
SHORT = 0.15
"""The same where only one thing is measured."""
ROUNDS = 3
"""So many at least."""
TURN = 0.005
"""Seconds for which each runs again and again before the next has its turn."""


def taking_turns(acts: Mapping[Key, Callable[[], object]]) -> dict[Key, Timing]:
    """Return how long each takes. They take turns, so that all meet the same load of the machine.

    A first round, which brings code and data to the caches, does not count.
    """
    for act in acts.values():
        act()
    return _rounds(acts, ROUNDS, BUDGET)


def repeated(act: Callable[[], object]) -> Timing:
    """Return how long it takes to make something, once if that is long."""
    return _rounds({"": act}, 1, SHORT)[""]


def _rounds(acts: Mapping[Key, Callable[[], object]], least: int, budget: float) -> dict[Key, Timing]:
    spent: dict[Key, list[float]] = {name: [] for name in acts}
    start, rounds = perf_counter(), 0
    while rounds < least or perf_counter() - start < budget:
        for name, act in acts.items():
            spent[name] += _turn(act)
        rounds += 1
    return {name: Timing(min(times), median(times), len(times)) for name, times in spent.items()}


def _turn(act: Callable[[], object]) -> list[float]:
    """Return seconds of every run of one turn."""
    times: list[float] = []
    now = begin = perf_counter()
    while not times or now - begin < TURN:
        act()
        before, now = now, perf_counter()
        times.append(now - before)
    return times


class Copying:
    """An array and a place for its copy, which together have so many bytes."""

    def __init__(self, size: int) -> None:
        self.source, self.target = (np.ones(max(size // 16, 1)) for _ in range(2))

    def __call__(self, threads: int) -> None:
        """Copies the array, a part by each thread."""
        parts = zip(np.array_split(self.target, threads), np.array_split(self.source, threads), strict=True)
        workers = [Thread(target=np.copyto, args=part) for part in parts]
        for worker in workers[1:]:
            worker.start()
        workers[0].run()
        for worker in workers[1:]:
            worker.join()


def largest_difference(found: NDArray[np.floating], expected: NDArray[np.floating]) -> float:
    """max |found - expected| / max |expected|; 0 where all are equal."""
    largest = float(np.abs(expected).max(initial=0.0))
    return float(np.abs(found - expected).max(initial=0.0)) / max(largest, float(np.finfo(float).tiny))
