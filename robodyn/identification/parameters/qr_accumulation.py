"""What a log says of columns, in triangular factors by fold and joint: one pass over the log, in memory of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robodyn.identification.log.log import Log
from robodyn.identification.log.rows import filtered
from robodyn.identification.parameters.regressor_columns import RegressorColumns
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

_WAITING = 1024
"""Rows that are added to a factor at a time."""
_OUTLIER = 3.0
"""Standard deviations above which a residual counts as if it were there (Huber)."""


class Guess:
    """A first fit: torques of regressor, and the standard deviation of each joint's residual.

    Attributes:
        values: (a,) by column; sigma: of each measured joint [N m].
        moments: of the rows that are fitted, and of their residuals as far as they are no outliers.
    """

    def __init__(self, regressor: RegressorColumns, values: Floats, sigma: Floats) -> None:
        self.values, self.sigma = values, sigma
        self.moments = Moments(regressor)

    def weights(self, columns: Sequence[Floats], residuals: Floats, fit: NDArray[np.bool_]) -> Floats:
        """Return (k, joints) the square roots of Huber's weights; add the rows that are fitted to the moments."""
        size = np.abs(residuals) / self.sigma
        weights = np.sqrt(np.minimum(1.0, _OUTLIER / np.maximum(size, 1e-300)))
        self.moments.add([each[fit] for each in columns], (residuals * weights * weights)[fit])
        return np.asarray(weights)


class Gathered:
    """Factors of the rows [columns, torque] of every joint in every fold.

    Attributes:
        regressor: the columns; parts: fold -> joint -> factor.
        squares: (folds, joints) of the measured torques [N^2 m^2]; described: of the description's residuals.
        channels: of each joint the rows of `gross_faults.told` that are fitted, if no guess was there.
    """

    def __init__(self, folds: int, regressor: RegressorColumns) -> None:
        self.regressor = regressor
        self.parts = [[Triangle.empty(width - 1) for width in regressor.widths] for _ in range(folds)]
        self.squares = np.zeros((folds, len(regressor.widths)))
        self.described = np.zeros_like(self.squares)
        self.channels = [Triangle.empty(4 + len(regressor.widths)) for _ in regressor.widths]
        self._waiting: dict[tuple[int, int], list[Floats]] = {}

    def add(self, fold: int, joint: int, rows: Floats) -> None:
        waiting = self._waiting.setdefault((fold, joint), [])
        waiting.append(rows)
        if sum(map(len, waiting)) >= _WAITING:
            self._settle(fold, joint)

    def finish(self) -> None:
        """Add the rows that wait."""
        for fold, joint in list(self._waiting):
            self._settle(fold, joint)

    def _settle(self, fold: int, joint: int) -> None:
        self.parts[fold][joint].add(np.concatenate(self._waiting.pop((fold, joint))))


def gather(
    log: Log,
    cutoff: float,
    regressor: RegressorColumns,
    edges: Sequence[float],
    plain: Gathered,
    weighted: Gathered | None = None,
    guess: Guess | None = None,
) -> None:
    """Add the rows of a log to the factors of their folds; with a first guess to weighted ones, too.

    Args:
        edges: times [s] at which a fold ends and the next begins, ascending.
    """
    if guess is not None:
        guess.moments.restart()
    for rows in filtered(log, cutoff, regressor.compute):
        folds = np.searchsorted(np.asarray(edges), rows.time, side="right")
        parts, described = [], []
        for j, columns in zip(regressor.measured, regressor.by_joint(rows.values), strict=True):
            parts.append(np.concatenate([columns[:, :-2], rows.tau[:, j, None] - columns[:, -2:-1]], axis=1))
            described.append(columns[:, -1] - rows.tau[:, j])
        weights, fit = None, folds < len(edges)
        if guess is not None:
            pairs = zip(parts, regressor.used, strict=True)
            off = [einsum("ka,a->k", part[:, :-1], guess.values[used]) - part[:, -1] for part, used in pairs]
            weights = guess.weights([part[:, :-1] for part in parts], np.stack(off, axis=1), fit)
        else:
            tau = rows.tau[:, regressor.measured]
            for joint, own in enumerate(regressor.own):
                channels = np.column_stack((parts[joint][:, own], described[joint] + tau[:, joint], tau))
                plain.channels[joint].add(channels[fit])
        for fold in np.unique(folds).tolist():
            own = folds == fold
            plain.squares[fold] += (rows.tau[own][:, regressor.measured] ** 2).sum(axis=0)
            plain.described[fold] += [(off[own] ** 2).sum() for off in described]
            for joint, part in enumerate(parts):
                plain.add(fold, joint, part[own])
                if weighted is not None and weights is not None:
                    weighted.squares[fold, joint] += float((part[own, -1] ** 2).sum())
                    weighted.add(fold, joint, part[own] * weights[own, joint, None])


@dataclass
class Triangle:
    """R with R^T R = A^T A of all rows A that were added: by QR updates, whose error is that of QR, not of squares.

    Attributes:
        R: (at most c, c).
        count: rows that were added.
    """

    R: Floats
    count: int = 0

    @classmethod
    def empty(cls, columns: int) -> Triangle:
        return cls(np.zeros((0, columns)))

    def add(self, rows: Floats) -> None:
        """Add rows (k, c)."""
        if len(rows):
            self.R = stacked([self.R, rows])
            self.count += len(rows)


def stacked(parts: list[Floats]) -> Floats:
    """Return the triangular factor of rows (k, c) of which there may be many, one below another."""
    return np.asarray(np.linalg.qr(np.concatenate(parts), mode="r"))


LAGS = 12
"""Rows apart up to which residuals are taken for correlated."""


class Moments:
    """Sums of products of rows that are some rows apart.

    Attributes:
        columns: of each measured joint (2 LAGS + 1, a, a): sum over k of x_k x_(k + lag)^T.
        residuals: (LAGS + 1, joints) of the residuals; count: rows of each joint.
    """

    def __init__(self, regressor: RegressorColumns) -> None:
        widths = [len(used) for used in regressor.used]
        self.columns = [np.zeros((2 * LAGS + 1, width, width)) for width in widths]
        self.residuals = np.zeros((LAGS + 1, len(widths)))
        self.count = 0
        self.restart()

    def restart(self) -> None:
        """Begin rows that do not follow those before."""
        self._columns = [np.zeros((0, each.shape[1])) for each in self.columns]
        self._residuals = np.zeros((0, len(self.columns)))

    def add(self, columns: Sequence[Floats], residuals: Floats) -> None:
        """Add consecutive rows: of each joint (k, a), and (k, joints) residuals."""
        self.count += len(residuals)
        for j, (new, sums) in enumerate(zip(columns, self.columns, strict=True)):
            whole = np.concatenate([self._columns[j], new])
            for lag, (first, second) in _apart(whole, len(new), 2 * LAGS):
                sums[lag] += first.T @ second
            self._columns[j] = whole[-2 * LAGS :]
        whole = np.concatenate([self._residuals, residuals])
        for lag, (first, second) in _apart(whole, len(residuals), LAGS):
            self.residuals[lag] += einsum("kj,kj->j", first, second)
        self._residuals = whole[-LAGS:]


def _apart(whole: Floats, new: int, lags: int) -> list[tuple[int, tuple[Floats, Floats]]]:
    """Return by lag the rows of which the later one is among the last `new`, and these."""
    old = len(whole) - new
    firsts = [(lag, max(old - lag, 0)) for lag in range(min(lags + 1, len(whole)))]
    return [(lag, (whole[first : len(whole) - lag], whole[first + lag :])) for lag, first in firsts]
