"""What a page shows of a motion, in bounded memory: of every bucket of rows the first, and the least and the greatest
value of each curve; all rows of motions that are short enough."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robodyn.support.floats import Floats

VALUES = 700_000
"""So many numbers of a motion are kept at most; buckets are twice as long where there would be more."""
LEAST, MOST = 600, 12_000
"""Buckets there may be at least, and at most."""


class Courses:
    """Gathers columns block by block, in buckets of `per` rows.

    Attributes:
        names: of the columns of `first` (B, columns): the first row of every bucket.
        curves: of the columns of `low` and `high` (B, curves): least and greatest values in the bucket.
        peaks: by curve the row of all columns where its magnitude is greatest, and its number from 0.
    """

    def __init__(self, names: Sequence[str], curves: Sequence[str]) -> None:
        self.names, self.curves = tuple(names), tuple(curves)
        self.per, self.rows = 1, 0
        width = len(self.names) + 2 * len(self.curves)
        self._most = max(LEAST, min(MOST, VALUES // max(width, 1)))
        self.first = np.empty((0, len(self.names)))
        self.low, self.high = (np.empty((0, len(self.curves))) for _ in range(2))
        self.peaks: dict[str, tuple[int, Floats]] = {}
        self._largest = np.full(len(self.curves), -1.0)
        self._last: Floats = np.empty(len(self.names))

    def update(self, columns: Sequence[Floats], curves: Sequence[Floats] | Floats) -> None:
        """Take in the next rows: each column, and each curve, of N values."""
        N = len(columns[0])
        numbers = np.arange(self.rows, self.rows + N)
        begins = np.flatnonzero(np.append(True, np.diff(numbers // self.per)))
        first = np.stack([column[begins] for column in columns], axis=1)
        values = np.array([*curves]) if len(curves) else np.empty((0, N))
        low, high = (extreme.reduceat(values, begins, axis=1).T for extreme in (np.minimum, np.maximum))
        self._keep_peaks(columns, values, np.maximum(-low, high).max(axis=0))
        if self.rows % self.per:  # goes on with the last bucket
            self.low[-1], self.high[-1] = np.minimum(self.low[-1], low[0]), np.maximum(self.high[-1], high[0])
            first, low, high = first[1:], low[1:], high[1:]
        self.rows += N
        self._last = np.array([column[-1] for column in columns])
        self.first = np.concatenate((self.first, first))
        self.low, self.high = np.concatenate((self.low, low)), np.concatenate((self.high, high))
        while len(self.first) > self._most:
            pairs = np.arange(0, len(self.first), 2)
            self.low, self.high = np.minimum.reduceat(self.low, pairs), np.maximum.reduceat(self.high, pairs)
            self.first, self.per = self.first[::2], 2 * self.per

    def _keep_peaks(self, columns: Sequence[Floats], values: Floats, largest: Floats) -> None:
        for k in np.flatnonzero(largest > self._largest):
            row = int(np.abs(values[k]).argmax())
            self._largest[k] = largest[k]
            self.peaks[self.curves[k]] = self.rows + row, np.array([column[row] for column in columns])

    def frames(self) -> tuple[Floats, Floats]:
        """Return numbers (F,) from 0 and rows (F, columns) of every bucket's first row, the curves' peaks, the last."""
        numbers = np.arange(float(len(self.first))) * self.per
        extra = [] if self.per == 1 else [*self.peaks.values(), (self.rows - 1, self._last)]
        numbers = np.concatenate((numbers, [number for number, _ in extra]))
        rows = np.concatenate((self.first, *(row[None] for _, row in extra)))
        numbers, kept = np.unique(numbers, return_index=True)
        return numbers, rows[kept]

    def of(self, name: str) -> tuple[Floats, Floats]:
        """Return (B,) each, the least and greatest values of a curve in every bucket."""
        k = self.curves.index(name)
        return self.low[:, k], self.high[:, k]
