"""Which samples of a motion may be the peak where parameters are uncertain: those that are it for some draws."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.variations import Variations
from robodyn.loads.statistics import Greatest
from robodyn.loads.uncertain_quantities import Figure
from robodyn.programs.vectors import product
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

DRAWS, SEED = 64, 190
WIDER = 1.5
"""Times the standard deviations that these draws have, so that the ends of intervals find their samples too."""
OUT_OF_REACH = 8.0
"""Standard errors that a sample is below the peak by, which then never rises to it."""


class UncertainPeaks:
    """Gathers the peaks of figures, and the samples that are the peak instead for some draws, block by block.

    Attributes:
        peaks: of the figures' magnitudes.
        at: (figures, 2, 1 + m) the columns of the peak, and their derivatives by theta.
        rivals: of each figure (samples, 2, 1 + m) likewise, of the samples that are the peak for some draws; less: of
            each figure (samples,) what is not sure of them, as peaks are chosen by.
    """

    def __init__(self, found: Variations, figures: Sequence[Figure]) -> None:
        self.found, self.figures = found, figures
        count, width = len(figures), 1 + len(found.jacobian)
        self.peaks, self.at = Greatest(count), np.zeros((count, 2, width))
        self.rivals, self.less = [np.zeros((0, 2, width))] * count, [np.zeros(0)] * count
        self._theta = found.theta(WIDER * found.even_draws(DRAWS, SEED))
        self._most, self._which = np.full((count, DRAWS), -np.inf), np.zeros((count, DRAWS), dtype=np.int64)

    def take(self, time: Floats, row: int, values: Floats, changes: Floats, less: Floats) -> None:
        """Take in a block.

        Args:
            row: the first of the block; values: all columns (columns, N); changes: (columns, N, m) by theta.
            less: (figures, N) what is not sure of the figures' magnitudes.
        """
        along = self.found.spread(changes)
        sizes = np.stack([each.size(values[each.columns]) for each in self.figures])
        for figure, at in self.peaks.update(time, row, sizes - less, off=less):
            self.at[figure] = self._both(figure, np.array([at]), values, changes)[0]
        for k, each in enumerate(self.figures):
            columns = each.columns
            near = self._near(k, values[columns], along[columns], sizes[k] - less[k])
            if len(near):
                drawn = values[columns][:, near, None] + product(changes[columns][:, near], self._theta.T)
                self._choose(k, near, each.size(drawn) - less[k, near, None], (values, changes, less[k]))

    def _near(self, k: int, values: Floats, along: Floats, sure: Floats) -> NDArray[np.int64]:
        """Return the samples of figure k that may rise to its peak.

        Args:
            values: (1 or 2, N); along: (1 or 2, N, p) of `Variations.spread`; sure: (N,) magnitude less doubts.
        """
        figure, at = self.figures[k], self.at[k, : len(values)]
        at_peak = self.found.spread(at[:, 1:])
        apart = figure.gradient(values, along) - figure.gradient(at[:, 0], at_peak)
        spread, errors = np.sqrt(einsum("nk,nk->n", apart, apart)), einsum("cnk,cnk->cn", along, along)
        across, gap = np.sqrt(errors.sum(0)), float(self.peaks.score[k]) - sure
        turns = figure.size(values) < OUT_OF_REACH * across
        if figure.lossy:
            turns |= np.abs(values[1]) < OUT_OF_REACH * np.sqrt(errors[1])
        own = np.sqrt(einsum("cp,cp->", at_peak, at_peak))
        return np.flatnonzero(gap <= OUT_OF_REACH * np.where(turns, across + own, spread))

    def _choose(self, k: int, near: NDArray[np.int64], drawn: Floats, of: tuple[Floats, Floats, Floats]) -> None:
        """Keep the samples where figure k is largest for some draw; drawn: (samples, draws)."""
        values, changes, less = of
        best = drawn.argmax(0)
        levels = np.take_along_axis(drawn, best[None], 0)[0]
        new = levels > self._most[k]
        if not new.any():
            return
        self._most[k] = np.where(new, levels, self._most[k])
        came, places = np.unique(near[best], return_inverse=True)
        which = np.where(new, len(self.rivals[k]) + places, self._which[k])
        left, self._which[k] = np.unique(which, return_inverse=True)
        rows = np.concatenate((self.rivals[k], self._both(k, came, values, changes)))
        self.rivals[k], self.less[k] = rows[left], np.concatenate((self.less[k], less[came]))[left]

    def _both(self, figure: int, at: NDArray[np.int64], values: Floats, changes: Floats) -> Floats:
        """Return (samples, 2, 1 + m) the columns of a figure at some samples, and their derivatives."""
        found = np.zeros((len(at), 2, 1 + changes.shape[-1]))
        for i, c in enumerate(self.figures[figure].columns):
            found[:, i, 0], found[:, i, 1:] = values[c, at], changes[c, at]
        return found
