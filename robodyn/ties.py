"""Orders and choices among numbers that rounding errors do not turn: numbers as good as equal are ties."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import isfinite
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

Item = TypeVar("Item")
NEAR = 1e-9
"""Numbers that differ by no more than this part of the larger one are ties."""
HALF_UP = 1.0 + 1e-12
"""Times this, a number half-way between two of few digits is printed as the larger one, whatever its last digits."""


def tie_margin(largest: float, noise: float = 0.0) -> float:
    """Return how far below the largest number a tie may lie.

    Args:
        noise: what arithmetic cannot tell from zero, in the unit of the number.
    """
    return max(NEAR * abs(largest), noise) if isfinite(largest) else 0.0


def ranked(items: Iterable[Item], key: Callable[[Item], float], noise: float = 0.0) -> list[Item]:
    """Return the items in descending order of their keys; ties, each next to the one before it, keep their order.

    Args:
        noise: keys that differ by no more than this are ties too.
    """
    given = list(items)
    keys = [float(key(item)) for item in given]
    order = sorted(range(len(given)), key=lambda k: -keys[k])
    found: list[int] = []
    group: list[int] = []
    for k in order:
        if group and keys[k] < keys[group[-1]] - tie_margin(keys[group[-1]], noise):
            found += sorted(group)
            group = []
        group.append(k)
    return [given[k] for k in (*found, *sorted(group))]


def first_largest(values: ArrayLike, noise: float = 0.0) -> int:
    """Return the index of the largest of some numbers, the first of ties; of the smallest with `-values`.

    Args:
        noise: numbers that are smaller by no more than this are ties too.
    """
    numbers = np.asarray(values, dtype=float)
    largest = float(numbers.max())
    return int(np.argmax(numbers >= largest - tie_margin(largest, noise)))
