"""Where a matrix that changes along a motion loses rank between two samples."""

from __future__ import annotations

import numpy as np

from robodyn.dynamics.constraints.structure import svd, times
from robodyn.support.floats import Floats


class RankChanges:
    """Watches matrices sample by sample, across pieces of a motion."""

    def __init__(self, rank: int) -> None:
        """Args: rank: the usual one."""
        self.rank = rank
        self._last: Floats | None = None

    def update(self, A: Floats) -> Floats:
        """Return (N,) for each sample what part of the way from the one before it the rank is lost at; else NaN.

        Along a smooth motion A = U S V^T has smooth singular values that may change their sign: from a sample to the
        next one, A_2, the eigenvalues of S^-1 U^T A_2 V are near 1 but for those, which become negative. That takes a
        change of A of at least the smallest of them, so that few pairs are looked at.

        Args:
            A: (N, p, m), equilibrated.
        """
        found = np.full(len(A), np.nan)
        before = A[:-1] if self._last is None else np.concatenate((self._last, A[:-1]))
        after = A[len(A) - len(before) :]
        self._last = A[-1:].copy()
        if not self.rank or not len(before):
            return found
        left, sizes, right = svd(before)
        smallest, largest = sizes[:, self.rank - 1], sizes[:, 0]
        step = np.sqrt(((after - before) ** 2).sum(axis=(1, 2)))
        pairs = np.flatnonzero((smallest <= step) & (smallest > np.finfo(float).eps * largest))
        if len(pairs):
            r = self.rank
            turned = times(
                times(left[pairs][:, :, :r].transpose(0, 2, 1), after[pairs]), right[pairs][:, :r].transpose(0, 2, 1)
            )
            least = np.linalg.eigvals(turned / sizes[pairs][:, :r, None]).real.min(axis=1)
            lost = least < 0.0
            found[pairs[lost] + len(A) - len(before)] = 1.0 / (1.0 - least[lost])
        return found
