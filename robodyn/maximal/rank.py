"""Which rows of a matrix depend on those before them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
DEPENDENT = 1e-10
"""A row is dependent if less than this part of it is left outside the span of the rows before it."""


class Rank(NamedTuple):
    """The independent rows, the dependent ones, and an orthonormal basis of the span of all, as rows."""

    independent: Floats
    dependent: Floats
    basis: Floats


def ranked(rows: Floats) -> Rank:
    """The rows one after another: each is independent unless it lies in the span of those before it.

    Gram and Schmidt's orthogonalisation, each row twice (Kahan and Parlett: "twice is enough").

    Args:
        rows: (m, n).
    """
    m, n = rows.shape
    basis = np.zeros((min(m, n), n))
    independent: list[int] = []
    dependent: list[int] = []
    for k, row in enumerate(rows):
        size, found = np.sqrt(row @ row), basis[: len(independent)]
        rest = row / size if size else row
        for _ in range(2):
            rest = rest - found.T @ (found @ rest)
        left = np.sqrt(rest @ rest)
        if left <= DEPENDENT or len(independent) == len(basis):
            dependent.append(k)
        else:
            basis[len(independent)] = rest / left
            independent.append(k)
    return Rank(np.array(independent, dtype=int), np.array(dependent, dtype=int), basis[: len(independent)])
