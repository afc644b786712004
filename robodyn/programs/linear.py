"""Small linear equations and eigenvalues in the same order of operations everywhere: what LAPACK gives differs in the
last digits from one processor to another."""

from __future__ import annotations

import sys
from itertools import combinations
from math import copysign, hypot, sqrt

import numpy as np

from robodyn.programs.vectors import length, product
from robodyn.support.floats import Floats

_EPS = sys.float_info.epsilon
_SWEEPS = 30


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


def min_norm_solution(A: Floats, b: Floats, nothing: float) -> Floats:
    """Return the shortest x with A x as near to b as it can be.

    Args:
        A: (m, n); what is no more than a part `nothing` of its largest row counts as dependent.
    """
    rows = range_basis(A, nothing)
    B = product(A, rows.T)
    columns = range_basis(B.T, 0.0)
    return np.asarray(product(rows.T, solve(product(columns, B), product(columns, b))))


def range_basis(rows: Floats, nothing: float) -> Floats:
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


def null_space(rows: Floats, nothing: float) -> Floats:
    """Return an orthonormal basis (n - r, n) across all rows (m, n); `nothing` as for `range_basis`."""
    basis = range_basis(rows, nothing)
    count, n = basis.shape
    return range_basis(np.eye(n) - product(basis.T, basis), 0.0)[: n - count]


def eigen(S: Floats) -> tuple[Floats, Floats]:
    """Return eigenvalues in descending order, and unit eigenvectors as rows: S = sum of s_i v_i v_i^T.

    The small eigenvalues are as accurate as the large.

    Method: cyclic Jacobi rotations until |S_ij| <= eps sqrt|S_ii S_jj| (Demmel, Veselic 1992: on a positive definite
    matrix D A D with D diagonal each eigenvalue is then found within the condition number of A alone, however far the
    entries of D are apart). What is diagonal or has only one product of inertia keeps its exact zeros.

    Args:
        S: (n, n) symmetric, finite; n is 3, or few more.

    Accuracy: eigenvalues within 8 eps times the condition number of the matrix scaled to a unit diagonal, each; in any
        case within 8 eps of the largest. Eigenvectors orthonormal within 8 eps.
    """
    a: list[list[float]] = S.tolist()
    n = len(a)
    v = [[float(i == k) for k in range(n)] for i in range(n)]
    for _ in range(_SWEEPS):
        turned = [_annihilate(a, v, p, q) for p, q in combinations(range(n), 2)]
        if not any(turned):
            break
    order = sorted(range(n), key=lambda i: -a[i][i])
    return np.array([a[i][i] for i in order]), np.array([v[i] for i in order])


def _annihilate(a: list[list[float]], v: list[list[float]], p: int, q: int) -> bool:
    """Turn axes p and q until a[p][q] is zero, unless it is negligible already."""
    off = a[p][q]
    if abs(off) <= _EPS * sqrt(abs(a[p][p])) * sqrt(abs(a[q][q])):
        return False
    theta = (a[q][q] - a[p][p]) / off / 2.0
    t = copysign(1.0, theta) / (abs(theta) + hypot(1.0, theta))
    c = 1.0 / hypot(1.0, t)
    s = t * c
    a[p][p] -= t * off
    a[q][q] += t * off
    a[p][q] = a[q][p] = 0.0
    for k in range(len(a)):
        if k not in (p, q):
            a[p][k], a[q][k] = c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]
            a[k][p], a[k][q] = a[p][k], a[q][k]
        v[p][k], v[q][k] = c * v[p][k] - s * v[q][k], s * v[p][k] + c * v[q][k]
    return True
