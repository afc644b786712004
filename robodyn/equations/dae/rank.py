"""Which rows of a matrix depend on those before them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import product

Floats = NDArray[np.float64]
DEPENDENT = 1e-10
"""A row is dependent if less than this part of it is left outside the span of the rows before it."""
BLOCK = 24
"""Rows."""
SHRUNK = 0.1
"""Of a row that had the length 1."""


class Rank(NamedTuple):
    """The independent rows, the dependent ones, and an orthonormal basis of the span of all, as rows."""

    independent: Floats
    dependent: Floats
    basis: Floats


def ranked(rows: Floats) -> Rank:
    """The rows one after another: each is independent unless it lies in the span of those before it.

    Gram and Schmidt's orthogonalisation, in blocks of rows for what came before the block; what is left of a row is
    taken again where it is little (Kahan and Parlett: "twice is enough").

    Args:
        rows: (m, n).
    """
    m, n = rows.shape
    basis = np.zeros((min(m, n), n))
    independent: list[int] = []
    dependent: list[int] = []
    sizes = np.sqrt((rows * rows).sum(axis=1))
    for start in range(0, m, BLOCK):
        first = len(independent)
        block = rows[start : start + BLOCK] / np.where(sizes > 0.0, sizes, 1.0)[start : start + BLOCK, None]
        for k, row in enumerate(_outside(block, basis[:first]), start):
            rest = _outside(row, basis[first : len(independent)])
            if product(rest, rest) < SHRUNK**2:
                rest = _outside(rest, basis[: len(independent)])
            left = np.sqrt(product(rest, rest))
            if left <= DEPENDENT or len(independent) == len(basis):
                dependent.append(k)
            else:
                basis[len(independent)] = rest / left
                independent.append(k)
    return Rank(np.array(independent, dtype=int), np.array(dependent, dtype=int), basis[: len(independent)])


def _outside(rows: Floats, basis: Floats) -> Floats:
    """What of rows lies outside the span of an orthonormal basis."""
    return np.asarray(rows - product(rows, basis.T, basis))
