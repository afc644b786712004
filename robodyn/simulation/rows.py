"""Steps of one length, which end at the rows of a table too."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats

NEAR = 8.0 * float(np.finfo(float).eps)
"""Times that differ by less than this part of them are the same: what rounding makes of a multiple of a step."""


class Piece(NamedTuple):
    """Steps that follow each other.

    Attributes:
        begin, end, length: (N,) s of each.
        whole: (N,) how many whole steps are done where it ends; 0 where it ends within one, at a row.
        row: (N,) whether it ends at a row.
    """

    begin: Floats
    end: Floats
    length: Floats
    whole: NDArray[np.int64]
    row: NDArray[np.bool_]

    def recorded(self, every: int) -> NDArray[np.intp]:
        """Return which of the steps are recorded: those that end at rows, and every so many whole ones."""
        return np.flatnonzero(self.row | (self.whole % every == 0))


def pieces(rows: Floats, h: float, count: int, size: int) -> Iterator[Piece]:
    """Yield `count` whole steps of length h from time 0 on, divided at the rows, at most `size` steps at a time.

    Args:
        rows: (N,) s, increasing.
    """
    nearest = np.rint(rows / h)
    apart = np.abs(rows - nearest * h) > NEAR * rows
    inner, outer = rows[apart], nearest[~apart].astype(np.int64)
    for first in range(0, count, size):
        steps = _divided(first, min(size, count - first), h, inner, outer)
        for k in range(0, len(steps.begin), size):
            some = slice(k, k + size)
            yield Piece(steps.begin[some], steps.end[some], steps.length[some], steps.whole[some], steps.row[some])


def _divided(first: int, count: int, h: float, rows: Floats, ends: NDArray[np.int64]) -> Piece:
    """`count` whole steps after `first` of them, divided at the rows, none of which is the end of a whole one.

    Args:
        ends: which whole steps end at other rows, increasing.
    """
    numbers = np.arange(first, first + count)
    starts, last = numbers * h, (first + count) * h
    inside = rows[slice(*np.searchsorted(rows, (starts[0], last)))]
    begin = np.sort(np.concatenate((starts, inside)))
    end = np.append(begin[1:], last)
    length, whole = end - begin, np.zeros(len(begin), np.int64)
    places = np.searchsorted(begin, starts)
    final = np.append(places[1:], len(begin)) - 1
    whole[final] = numbers + 1
    length[places[final == places]] = h
    row = whole == 0
    row[final[ends[slice(*np.searchsorted(ends, (first + 1, first + count + 1)))] - first - 1]] = True
    return Piece(begin, end, length, whole, row)
