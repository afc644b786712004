"""Least squares of many small matrices at once, in the same order of operations everywhere."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

TINY = 1e-300


class LeastSquares(NamedTuple):
    """The solutions of many least-squares problems.

    Attributes:
        x: (N, k, r).
        rest: (N, r) lengths of what is left of the right sides.
        ratio: (N,) the smallest entry of R's diagonal over the largest: about the inverse of the condition; 0 if k > m.
        sign: (N,) of det A where m = k, else of what rotates continuously with it; 0 where ratio is.
    """

    x: Floats
    rest: Floats
    ratio: Floats
    sign: Floats


def least_squares(A: Floats, B: Floats) -> LeastSquares:
    """Return X with |A X - B| least, matrix by matrix, by Householder's reflections with the largest column first.

    Where columns depend on each other, X is not unique and large: look at `ratio` (Golub and Van Loan, Matrix
    Computations, algorithm 5.4.1).

    Args:
        A: (N, m, k). B: (N, m, r).

    Accuracy: 1e-14 of the largest entry of X over `ratio`.
    """
    N, m, k = A.shape
    W, order, sign = _triangular(A, B)
    diagonal = np.stack([W[j, j] if j < m else np.zeros(N) for j in range(k)]) if k else np.ones((1, N))
    size = np.abs(diagonal)
    ratio = size.min(axis=0) / np.maximum(size.max(axis=0), TINY)
    sign *= np.prod(np.sign(diagonal), axis=0) * (-1.0) ** min(k, m)
    rest = np.sqrt(einsum("irn,irn->nr", W[k:, k:], W[k:, k:]))
    return LeastSquares(_substituted(W, order, k), rest, ratio, sign)


def orthogonal(A: Floats) -> Floats:
    """Return Q (N, m, m) of A P = Q R: its first r columns span the columns of A, the others stand across them.

    Method: as `least_squares`; r is the rank of A (N, m, k).

    Accuracy: Q^T Q = 1 within 1e-14; the spans within 1e-14 over the condition of A's independent columns.
    """
    N, m, k = A.shape
    W, _, _ = _triangular(A, np.broadcast_to(np.eye(m), (N, m, m)))
    return np.asarray(W[:, k:].transpose(2, 1, 0))


def _triangular(A: Floats, B: Floats) -> tuple[Floats, NDArray[np.int64], Floats]:
    """Return W (m, k + r, N), R and Q^T B beside each other; the order of A's columns; and the sign of their swaps."""
    N, m, k = A.shape
    W = np.concatenate((A, B), axis=2).transpose(1, 2, 0).copy()
    order: NDArray[np.int64] = np.repeat(np.arange(k)[:, None], N, axis=1)
    sign, samples = np.ones(N), np.arange(N)
    for j in range(min(m, k)):
        squares = einsum("ijn,ijn->jn", W[j:, j:k], W[j:, j:k])
        largest = j + np.argmax(squares, axis=0)
        sign[largest != j] *= -1.0
        for each in (W.transpose(1, 0, 2), order):
            each[j], each[largest, ..., samples] = each[largest, ..., samples].T.copy(), each[j].T.copy()
        _reflect(W, j, np.sqrt(squares[largest - j, samples]))
    return W, order, sign


def _reflect(W: Floats, j: int, norm: Floats) -> None:
    """Take column j below row j to the negative of its first entry's sign times `norm`, all others with it."""
    v = W[j:, j].copy()
    v[0] += np.copysign(norm, v[0])
    twice = 2.0 / np.maximum(einsum("in,in->n", v, v), TINY)
    W[j:, j:] -= v[:, None] * (twice * einsum("in,ijn->jn", v, W[j:, j:]))


def _substituted(W: Floats, order: NDArray[np.int64], k: int) -> Floats:
    """Return X (N, k, r) of R X = Q^T B, in the order of A's columns."""
    m, width, N = W.shape
    X = np.zeros((k, width - k, N))
    for j in reversed(range(min(k, m))):
        left = W[j, k:] - einsum("in,irn->rn", W[j, j + 1 : k], X[j + 1 :])
        X[j] = left / np.where(W[j, j] == 0.0, np.inf, W[j, j])
    out = np.empty_like(X)
    np.put_along_axis(out, order[:, None, :], X, axis=0)
    return out.transpose(2, 0, 1)
