"""Times of methods that take turns, with their spread."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

BUDGET = 1.0
"""Seconds for which rounds are repeated."""
ROUNDS = 5
"""So many at least, and at most 200 times as many."""
SLOW = 0.5
"""Seconds from which one run has to do."""

SHORT = 0.01
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
    """What each act returns and how long it takes.

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
    while rounds < ROUNDS or (perf_counter() - start < BUDGET and rounds < 200 * ROUNDS):
        for name, times in spent.items():
            if first[name] < SHORT:
                acts[name]()
            times.append(_run(acts[name])[1])
        rounds += 1
    return {name: (result, Spread.of(spent.get(name) or [first[name]], share)) for name, result in results.items()}


def _run(act: Callable[[], Any]) -> tuple[Any, float]:
    begin = perf_counter()
    result = act()
    return result, perf_counter() - begin
