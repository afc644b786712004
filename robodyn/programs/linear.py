"""Dense linear equations in the same order of operations everywhere: what LAPACK gives differs in the last digits from
one processor to another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import length, product

Floats = NDArray[np.float64]


def solve(A: Floats, B: Floats) -> Floats:
    """Return X with A X = B, by elimination with the largest pivot of each column.

    Args:
        A: (n, n). B: (n,) or (n, k).

    Raises:
        numpy.linalg.LinAlgError: a pivot is zero.
    """
    n = len(A)
    W = np.column_stack((A, B)).astype(float)
    for k in range(n):
        pivot = k + int(np.argmax(np.abs(W[k:, k])))
        if W[pivot, k] == 0.0:
            raise np.linalg.LinAlgError("singular matrix")
        W[[k, pivot], k:] = W[[pivot, k], k:]
        W[k + 1 :, k:] -= (W[k + 1 :, k] / W[k, k])[:, None] * W[k, k:]
    X = W[:, n:]
    for k in reversed(range(n)):
        X[k] = (X[k] - product(W[k, k + 1 : n], X[k + 1 :])) / W[k, k]
    return X.reshape(np.shape(B))


def shortest(A: Floats, b: Floats, nothing: float) -> Floats:
    """Return the shortest x with A x as near to b as it can be.

    Args:
        A: (m, n); what is no more than a part `nothing` of its largest row counts as dependent.
    """
    rows = span(A, nothing)
    B = product(A, rows.T)
    columns = span(B.T, 0.0)
    return np.asarray(product(rows.T, solve(product(columns, B), product(columns, b))))


def span(rows: Floats, nothing: float) -> Floats:
    """Return an orthonormal basis (r, n) of the span of rows (m, n), but for a part `nothing` of the largest row.

    Method: Gram and Schmidt's, the largest that is left first, each vector twice.
    """
    left, basis = np.array(rows, dtype=float), np.zeros((min(rows.shape), rows.shape[1]))
    smallest = nothing * np.sqrt((left * left).sum(axis=1).max(initial=0.0))
    for k in range(len(basis)):
        sizes = np.sqrt((left * left).sum(axis=1))
        largest = int(np.argmax(sizes))
        if sizes[largest] <= smallest:
            return basis[:k]
        one = left[largest] / sizes[largest]
        one = one - product(basis[:k], one, basis[:k])
        basis[k] = one / length(one)
        left -= product(left, basis[k])[:, None] * basis[k]
        left[largest] = 0.0
    return basis


def across(rows: Floats, nothing: float) -> Floats:
    """Return an orthonormal basis (n - r, n) of what stands across all rows (m, n); `nothing` is as for `span`."""
    basis = span(rows, nothing)
    count, n = basis.shape
    return span(np.eye(n) - product(basis.T, basis), 0.0)[: n - count]
