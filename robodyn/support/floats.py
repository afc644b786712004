"""Floating-point numbers: the type of arrays, sums, and orders and choices that rounding errors do not turn. Numbers
that are the same in their first 30 bits (within 1e-9) are ties: where they come from depends on the processor in their
last bits, what a user sees must not. Limits between two such numbers have 31 bits, which no number has by design."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

Item = TypeVar("Item")
Floats = NDArray[np.float64]
LARGEST = 1e30
"""In SI units no part of a robot has a larger number; the tenth power of this one can still be held."""
SMALLEST = 1e-60
"""What is less is what rounding left of zero, as in files that CAD systems write, and counts as zero."""
BEYOND = 1.0 + 1e-9
"""Times this, a limit is exceeded by what is larger, and not by what a motion up to the limit is off by rounding."""
HALF_UP = 1.0 + 1e-12
"""Times this, a number half-way between two of few digits is printed as the larger one, whatever its last digits."""


def median(values: ArrayLike) -> float:
    """Return the median of all of some numbers; NumPy's loads its masked arrays."""
    ordered = np.sort(np.asarray(values, dtype=float), axis=None)
    return float(0.5 * (ordered[(len(ordered) - 1) // 2] + ordered[len(ordered) // 2]))


def steady(numbers: ArrayLike, noise: float = 0.0) -> Floats:
    """Return the numbers rounded to 30 bits for comparisons (Veltkamp's splitting, Dekker 1971), and 0 within their
    `noise`."""
    given = np.asarray(numbers, dtype=float)
    with np.errstate(over="ignore", invalid="ignore"):
        large = given * (2.0**23 + 1.0)
        found: Floats = large - (large - given)
    if noise:
        found = np.where(np.abs(given) <= noise, 0.0, found)
    return np.where(np.isfinite(found), found, given)


def ranked(items: Iterable[Item], key: Callable[[Item], float], noise: float = 0.0) -> list[Item]:
    """Return the items in descending order of their keys; ties keep their order. For noise see `steady`."""
    given = list(items)
    keys = steady([key(item) for item in given], noise).tolist()
    return [given[k] for k in sorted(range(len(given)), key=lambda k: -keys[k])]


def first_of_ties(rows: Floats) -> NDArray[np.int64]:
    """Return for each row (k, N) the place of its largest number, the first of ties: `first_largest` of each."""
    level = steady(rows.max(axis=1))
    below = np.nextafter(np.where(np.isfinite(level), level, 0.0), -np.inf)
    found: NDArray[np.int64] = (rows >= (level - 2.0**22 * np.spacing(np.abs(below)))[:, None]).argmax(axis=1)
    return found


def first_largest(values: ArrayLike, noise: float = 0.0) -> int:
    """Return the place of the largest of some numbers, the first of ties; of the smallest if given `-values`."""
    return int(np.argmax(steady(values, noise)))


def einsum(subscripts: str, *factors: Any, optimize: bool = False) -> Any:
    """Return `np.einsum`, and zeros where a factor is empty: NumPy 2.4 leaves there what stood in memory, or does not,
    as the layout of the heap has it."""
    found = np.einsum(subscripts, *factors, optimize=optimize)
    if all(map(np.size, factors)):
        return found
    return np.zeros(np.shape(found), np.asarray(found).dtype)[()]


def unit_columns(A: Floats) -> tuple[Floats, Floats]:
    """Return A (k, p) with columns at unit length, and their lengths (p,); 1 of those that are zero."""
    lengths = np.sqrt(einsum("ij,ij->j", A, A))
    lengths = np.where(lengths > 0.0, lengths, 1.0)
    return A / lengths, lengths
