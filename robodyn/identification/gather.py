"""What a log says of columns, in triangular factors by fold and joint: one pass over the log, in memory of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robodyn.identification.atoms import Atoms
from robodyn.identification.log import Log
from robodyn.identification.moments import Moments
from robodyn.identification.rows import filtered
from robodyn.identification.triangle import Triangle
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

_WAITING = 1024
"""Rows that are added to a factor at a time."""
_OUTLIER = 3.0
"""Standard deviations above which a residual counts as if it were there (Huber)."""


class Guess:
    """A first fit: torques of atoms, and the standard deviation of each joint's residual.

    Attributes:
        values: (a,) by atom; sigma: of each measured joint [N m].
        moments: of the rows that are fitted, and of their residuals as far as they are no outliers.
    """

    def __init__(self, atoms: Atoms, values: Floats, sigma: Floats) -> None:
        self.values, self.sigma = values, sigma
        self.moments = Moments(atoms)

    def weights(self, columns: Sequence[Floats], residuals: Floats, fit: NDArray[np.bool_]) -> Floats:
        """Return (k, joints) the square roots of Huber's weights; add the rows that are fitted to the moments."""
        size = np.abs(residuals) / self.sigma
        weights = np.sqrt(np.minimum(1.0, _OUTLIER / np.maximum(size, 1e-300)))
        self.moments.add([each[fit] for each in columns], (residuals * weights * weights)[fit])
        return np.asarray(weights)


class Gathered:
    """Factors of the rows [columns, torque] of every joint in every fold.

    Attributes:
        atoms: the columns; parts: fold -> joint -> factor.
        squares: (folds, joints) of the measured torques [N^2 m^2]; described: of the description's residuals.
        channels: of each joint the rows of `gross_faults.told` that are fitted, if no guess was there.
    """

    def __init__(self, folds: int, atoms: Atoms) -> None:
        self.atoms = atoms
        self.parts = [[Triangle.empty(width - 1) for width in atoms.widths] for _ in range(folds)]
        self.squares = np.zeros((folds, len(atoms.widths)))
        self.described = np.zeros_like(self.squares)
        self.channels = [Triangle.empty(4 + len(atoms.widths)) for _ in atoms.widths]
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
    atoms: Atoms,
    edges: Sequence[float],
    plain: Gathered,
    weighted: Gathered | None = None,
    guess: Guess | None = None,
) -> None:
    """Add the rows of a log to the factors of their folds; with a first guess to weighted ones, too.

    Args:
        edges: times [s] at which a fold ends and the next begins, ascending.
    """
    splits = np.cumsum(atoms.widths)[:-1]
    if guess is not None:
        guess.moments.restart()
    for rows in filtered(log, cutoff, atoms.compute):
        folds = np.searchsorted(np.asarray(edges), rows.time, side="right")
        parts, described = [], []
        for j, columns in zip(atoms.measured, np.split(rows.values, splits, axis=1), strict=True):
            parts.append(np.concatenate([columns[:, :-2], rows.tau[:, j, None] - columns[:, -2:-1]], axis=1))
            described.append(columns[:, -1] - rows.tau[:, j])
        weights, fit = None, folds < len(edges)
        if guess is not None:
            pairs = zip(parts, atoms.used, strict=True)
            off = [einsum("ka,a->k", part[:, :-1], guess.values[used]) - part[:, -1] for part, used in pairs]
            weights = guess.weights([part[:, :-1] for part in parts], np.stack(off, axis=1), fit)
        else:
            tau = rows.tau[:, atoms.measured]
            for joint, own in enumerate(atoms.own):
                channels = np.column_stack((parts[joint][:, own], described[joint] + tau[:, joint], tau))
                plain.channels[joint].add(channels[fit])
        for fold in np.unique(folds).tolist():
            own = folds == fold
            plain.squares[fold] += (rows.tau[own][:, atoms.measured] ** 2).sum(axis=0)
            plain.described[fold] += [(off[own] ** 2).sum() for off in described]
            for joint, part in enumerate(parts):
                plain.add(fold, joint, part[own])
                if weighted is not None and weights is not None:
                    weighted.squares[fold, joint] += float((part[own, -1] ** 2).sum())
                    weighted.add(fold, joint, part[own] * weights[own, joint, None])
