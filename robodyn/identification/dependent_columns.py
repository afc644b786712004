"""Least squares of columns that may depend on each other, and Wald's test of what they come to."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

DEPENDENT = 1e-6
"""Of its length, what a column has at most beside those before it, if it is taken to depend on them."""

_PART = 1e-5
"""Of a column's length, what another one adds at least."""


def independent(rows: Floats, wanted: Sequence[int]) -> set[int]:
    """Return those of the wanted columns that do not depend on the wanted ones before them."""
    basis, found = np.zeros((len(rows), len(wanted))), list[int]()
    for place in wanted:
        column, before = rows[:, place], basis[:, : len(found)]
        size = np.sqrt(einsum("i,i", column, column))
        if size == 0.0:
            continue
        rest = column / size
        for _ in range(2):
            rest = rest - einsum("ia,a->i", before, einsum("ia,i->a", before, rest))
        left = np.sqrt(einsum("i,i", rest, rest))
        if left > DEPENDENT:
            basis[:, len(found)] = rest / left
            found.append(place)
    return {*found}


def depended_on(rows: Floats, chosen: Collection[int], others: Collection[int]) -> set[int]:
    """Return those of the chosen, independent columns of which some of the others are made."""
    places, sizes = sorted(chosen), np.sqrt(einsum("ij,ij->j", rows, rows))
    found: set[int] = set()
    for other in others:
        parts = least_squares(np.column_stack((rows[:, :-1], rows[:, other])), places) * sizes[:-1]
        found |= {place for place in places if abs(parts[place]) > _PART * sizes[other]}
    return found


def pseudoinverse(matrix: Floats) -> Floats:
    """Return the pseudoinverse, of columns scaled to length 1."""
    size = np.sqrt(einsum("ij,ij->j", matrix, matrix))
    size = np.where(size > 0.0, size, 1.0)
    return np.linalg.pinv(matrix / size, rcond=1e-10) / size[:, None]


def least_squares(rows: Floats, told: Collection[int]) -> Floats:
    """Return the least squares solution in these columns, zero elsewhere; the last column is the right side."""
    found, places = np.zeros(rows.shape[1] - 1), sorted(told)
    if places:
        found[places] = einsum("ij,j->i", pseudoinverse(rows[:, places]), rows[:, -1])
    return found


def wald(estimate: Floats, covariance: Floats, places: Sequence[int]) -> tuple[float, int]:
    """Return the square of an estimate in units of its covariance, and how many numbers it has."""
    if not places:
        return 0.0, 1
    part = covariance[np.ix_(places, places)]
    size = np.sqrt(np.clip(np.diag(part), 1e-300, None))
    values, vectors = np.linalg.eigh(part / np.outer(size, size))
    along = einsum("ia,i->a", vectors, estimate[places] / size)
    good = values > 1e-9 * values[-1]
    return float((along[good] ** 2 / values[good]).sum()), int(good.sum())
