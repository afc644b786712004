"""What a log says of columns, in triangular factors by fold and joint: one pass over the log, in memory of its own."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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


class Triangle:
    """R with R^T R = A^T A of all rows A (k, c) that were added, `count` of them, by QR: no squares lose digits."""

    def __init__(self, columns: int) -> None:
        self.count, self._new = 0, 0
        self._parts = [np.zeros((0, columns))]

    def add(self, rows: Floats) -> None:
        self._parts.append(rows)
        self.count += len(rows)
        self._new += len(rows)
        if self._new >= _WAITING:
            self._parts, self._new = [self.R], 0

    @property
    def R(self) -> Floats:
        """(at most c, c)."""
        if len(self._parts) > 1:
            self._parts = [stacked(self._parts)]
        return self._parts[0]


def stacked(parts: list[Floats]) -> Floats:
    """Return the triangular factor of rows (k, c) of which there may be many, one below another."""
    return np.asarray(np.linalg.qr(np.concatenate(parts), mode="r"))


class Gathered:
    """Factors of the rows [columns, torque] of every joint in every fold.

    Attributes:
        parts: fold -> joint -> factor.
        squares: (folds, joints) of the measured torques [N^2 m^2]; described: of the description's residuals.
        channels: of each joint the rows of `channels.told` that are fitted, if no guess was there.
    """

    def __init__(self, folds: int, regressor: RegressorColumns) -> None:
        self.regressor = regressor
        self.parts = [[Triangle(width - 1) for width in regressor.widths] for _ in range(folds)]
        self.squares = np.zeros((folds, len(regressor.widths)))
        self.described = np.zeros_like(self.squares)
        self.channels = [Triangle(4 + len(regressor.widths)) for _ in regressor.widths]


@dataclass(eq=False)
class Guess:
    """A first fit: values by column (a,), and the standard deviation of each joint's residual [N m].

    Attributes:
        moments: of the rows that are fitted, and of their residuals as far as they are no outliers.
    """

    values: Floats
    sigma: Floats
    moments: Moments

    def weights(self, columns: Sequence[Floats], residuals: Floats, fit: NDArray[np.bool_]) -> Floats:
        """Return (k, joints) the square roots of Huber's weights; add the rows that are fitted to the moments."""
        huber = np.minimum(1.0, _OUTLIER / np.maximum(np.abs(residuals) / self.sigma, 1e-300))
        self.moments.add([each[fit] for each in columns], (residuals * huber)[fit])
        return np.sqrt(huber)


def gather(
    log: Log, cutoff: float, edges: Sequence[float], plain: Gathered, weighted: Gathered, guess: Guess | None = None
) -> None:
    """Add the rows of a log to the factors of their folds; with a first guess to those of Huber's weights, too.

    Args:
        edges: times [s] at which a fold ends and the next begins, ascending.
    """
    regressor = plain.regressor
    if guess is not None:
        guess.moments.restart()
    for rows in filtered(log, cutoff, regressor.compute):
        folds = np.searchsorted(np.asarray(edges), rows.time, side="right")
        fit, tau = folds < len(edges), rows.tau[:, regressor.measured]
        parts, described = [], []
        for columns, own in zip(regressor.by_joint(rows.values), tau.T, strict=True):
            parts.append(np.column_stack((columns[:, :-2], own - columns[:, -2])))
            described.append(columns[:, -1] - own)
        if guess is not None:
            pairs = zip(parts, regressor.used, strict=True)
            off = np.stack([part[:, :-1] @ guess.values[used] - part[:, -1] for part, used in pairs], axis=1)
            weights = guess.weights([part[:, :-1] for part in parts], off, fit)
        else:
            for joint, own in enumerate(regressor.own):
                channels = np.column_stack((parts[joint][:, own], described[joint] + tau[:, joint], tau))
                plain.channels[joint].add(channels[fit])
        for fold in np.unique(folds).tolist():
            own = folds == fold
            plain.squares[fold] += (tau[own] ** 2).sum(axis=0)
            plain.described[fold] += [(each[own] ** 2).sum() for each in described]
            for joint, part in enumerate(parts):
                plain.parts[fold][joint].add(part[own])
                if guess is not None:
                    weighted.squares[fold, joint] += float((part[own, -1] ** 2).sum())
                    weighted.parts[fold][joint].add(part[own] * weights[own, joint, None])


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
        self._columns = [np.zeros((0, each.shape[1])) for each in self.columns]
        self._residuals = np.zeros((0, len(self.columns)))

    def add(self, columns: Sequence[Floats], residuals: Floats) -> None:
        """Add consecutive rows: of each joint (k, a), and (k, joints) residuals."""
        self.count += len(residuals)
        for j, (new, sums) in enumerate(zip(columns, self.columns, strict=True)):
            self._columns[j] = whole = np.concatenate([self._columns[j][-2 * LAGS :], new])
            for lag, (first, second) in enumerate(_apart(whole, len(new), 2 * LAGS)):
                sums[lag] += first.T @ second
        self._residuals = whole = np.concatenate([self._residuals[-LAGS:], residuals])
        for lag, (first, second) in enumerate(_apart(whole, len(residuals), LAGS)):
            self.residuals[lag] += einsum("kj,kj->j", first, second)


def _apart(whole: Floats, new: int, lags: int) -> Iterator[tuple[Floats, Floats]]:
    """Yield by lag the rows of which the later one is among the last `new`, and these."""
    for lag in range(min(lags + 1, len(whole))):
        first = max(len(whole) - new - lag, 0)
        yield whole[first : len(whole) - lag], whole[first + lag :]
