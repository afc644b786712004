"""Householder's QR in one order of sums, whatever the processor."""

from __future__ import annotations

import numpy as np

from robodyn.programs.vectors import product
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum


def reflect(A: Floats, k: int) -> None:
    """Turn the rows from k on so that column k is zero under its diagonal; in place, columns before k are done."""
    v = A[k:, k].copy()
    size = np.sqrt(einsum("i,i->", v, v))
    if size == 0.0:
        return
    v[0] += np.copysign(size, v[0])
    v /= np.sqrt(einsum("i,i->", v, v))
    A[k:, k:] -= 2.0 * v[:, None] * product(v, A[k:, k:])
    A[k + 1 :, k] = 0.0


def triangular(A: Floats) -> Floats:
    """Return R (min(k, p), p) upper triangular with R^T R = A^T A, for A (k, p)."""
    R = np.array(A, dtype=float)
    for k in range(min(R.shape)):
        reflect(R, k)
    return R[: min(R.shape)]


def back_substituted(T: Floats, B: Floats) -> Floats:
    """Return X with T X = B for an upper triangular T (n, n) and B (n,) or (n, k)."""
    X = np.array(B, dtype=float)
    for k in reversed(range(len(T))):
        X[k] = (X[k] - product(T[k, k + 1 :], X[k + 1 :])) / T[k, k]
    return X
