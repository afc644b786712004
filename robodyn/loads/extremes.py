"""The least and the greatest of several quantities along a motion, block by block."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robodyn.support.ties import first_of_ties, steady

Floats = NDArray[np.float64]


class Extremes:
    """Where each of some columns is smallest and largest; of ties the first counts.

    Attributes:
        least, greatest: (k,) values.
        least_time, greatest_time: (k,) when [s].
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        k = len(self.names)
        self.least, self.greatest = np.full(k, np.inf), np.full(k, -np.inf)
        self.least_time, self.greatest_time = np.zeros(k), np.zeros(k)

    def update(self, time: Floats, values: Floats) -> None:
        """Take in a block: time (N,) and values (N, k), N > 0."""
        columns = np.arange(len(self.names))
        low, high = first_of_ties(-values.T), first_of_ties(values.T)
        lower = steady(values[low, columns]) < steady(self.least)
        higher = steady(values[high, columns]) > steady(self.greatest)
        self.least = np.where(lower, values[low, columns], self.least)
        self.least_time = np.where(lower, time[low], self.least_time)
        self.greatest = np.where(higher, values[high, columns], self.greatest)
        self.greatest_time = np.where(higher, time[high], self.greatest_time)


class Greatest:
    """For each of several columns the sample at which a score is greatest; of ties the first counts.

    Attributes:
        score: (k,) the greatest; time: (k,) when [s]; row: (k,) of the data, from 1.
        kept: by name (k,) what else was given of that sample.
    """

    def __init__(self, columns: int) -> None:
        self.score = np.full(columns, -np.inf)
        self.time, self.row = np.zeros(columns), np.zeros(columns, dtype=np.int64)
        self.kept: dict[str, Floats] = {}

    def update(self, time: Floats, first_row: int, score: Floats, **values: Floats) -> None:
        """Take in a block: time (N,), score and further values (k, N), N > 0."""
        columns = np.arange(len(score))
        at = first_of_ties(score)
        new = steady(score[columns, at]) > steady(self.score)
        self.score = np.where(new, score[columns, at], self.score)
        self.time = np.where(new, time[at], self.time)
        self.row = np.where(new, at + first_row, self.row)
        for name, of in values.items():
            self.kept[name] = np.where(new, of[columns, at], self.kept.get(name, 0.0))
