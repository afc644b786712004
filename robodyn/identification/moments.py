"""How rows of a regressor, and their residuals, repeat themselves: sums of products at each lag."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robodyn.identification.atoms import Atoms
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

LAGS = 12
"""Rows apart up to which residuals are taken for correlated."""


class Moments:
    """Sums of products of rows that are some rows apart.

    Attributes:
        columns: of each measured joint (2 LAGS + 1, a, a): sum over k of x_k x_(k + lag)^T.
        residuals: (LAGS + 1, joints) of the residuals; count: rows of each joint.
    """

    def __init__(self, atoms: Atoms) -> None:
        widths = [len(used) for used in atoms.used]
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
        pairs = zip(self._columns, columns, strict=True)
        self._columns = [_added(*pair, sums) for pair, sums in zip(pairs, self.columns, strict=True)]
        whole = np.concatenate([self._residuals, residuals])
        for lag, (first, second) in _apart(whole, len(residuals), LAGS):
            self.residuals[lag] += einsum("kj,kj->j", first, second)
        self._residuals = whole[-LAGS:]


def _added(last: Floats, new: Floats, sums: Floats) -> Floats:
    whole = np.concatenate([last, new])
    for lag, (first, second) in _apart(whole, len(new), 2 * LAGS):
        sums[lag] += first.T @ second
    return whole[-2 * LAGS :]


def _apart(whole: Floats, new: int, lags: int) -> list[tuple[int, tuple[Floats, Floats]]]:
    """Return by lag the rows of which the later one is among the last `new`, and these."""
    old = len(whole) - new
    firsts = [(lag, max(old - lag, 0)) for lag in range(min(lags + 1, len(whole)))]
    return [(lag, (whole[first : len(whole) - lag], whole[first + lag :])) for lag, first in firsts]
