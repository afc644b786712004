"""Linear algebra of small matrices, and of many at once."""

from __future__ import annotations

import sys
from itertools import combinations
from math import copysign, hypot, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats

Complexes = NDArray[np.complex128]

_EPS = sys.float_info.epsilon
_SWEEPS = 30
_TINY = 1e-300


def min_norm_solution(A: Floats, b: Floats, nothing: float) -> Floats:
    """Return the shortest x with A x as near to b as it can be; A (m, n), `nothing` as for `range_basis`."""
    return np.asarray(np.linalg.lstsq(A, b, rcond=nothing)[0])


def range_basis(rows: Floats, nothing: float) -> Floats:
    """Return an orthonormal basis (r, n) of the span of rows (m, n); singular values that are no more than this part of
    the largest count as `nothing`."""
    _, sizes, right = np.linalg.svd(rows, full_matrices=False)
    return np.asarray(right[sizes > nothing * sizes.max(initial=0.0)])


def null_space(rows: Floats, nothing: float) -> Floats:
    """Return an orthonormal basis (n - r, n) across all rows (m, n); `nothing` as for `range_basis`."""
    _, sizes, right = np.linalg.svd(rows)
    return np.asarray(right[np.count_nonzero(sizes > nothing * sizes.max(initial=0.0)) :])


def pseudo_inverse(A: Floats) -> tuple[Floats, Floats]:
    """Return A^+ (N, k, m) of matrices (N, m, k) of rank k, and about the inverse of their conditions; 0 where less."""
    _, m, k = A.shape
    if m == k:
        try:
            inverse = np.linalg.inv(A)
        except np.linalg.LinAlgError:
            pass  # one of them is singular
        else:
            condition = np.linalg.norm(A, axis=(1, 2)) * np.linalg.norm(inverse, axis=(1, 2))
            return np.asarray(inverse), np.asarray(1.0 / np.maximum(condition, 1.0))
    left, sizes, right = np.linalg.svd(A, full_matrices=False)
    ratio = sizes[:, -1] / np.maximum(sizes[:, 0], _TINY) if 0 < k <= m else np.full(len(A), float(not k))
    inverse = np.swapaxes(right / np.maximum(sizes, _TINY)[:, :, None], 1, 2) @ np.swapaxes(left, 1, 2)
    return inverse, ratio


def eigen(S: Floats) -> tuple[Floats, Floats]:
    """Return eigenvalues of S (n, n), symmetric, finite and small, in descending order, and unit eigenvectors as rows.

    Method: cyclic Jacobi rotations until |S_ij| <= eps sqrt|S_ii S_jj| (Demmel, Veselic 1992: on a positive definite
    matrix D A D with D diagonal each eigenvalue is then found within the condition number of A alone, however far the
    entries of D are apart). What is diagonal or has only one product of inertia keeps its exact zeros.

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


class Eigen(NamedTuple):
    """A right_k = value_k right_k and left_k^H A = value_k left_k^H, for the unit columns of right and left; values are
    not sorted.

    Attributes:
        conditions: (n,) |left_k| |right_k| / |left_k^H right_k|: how far a change of the scaled matrix moves value_k.
        size: of the scaled matrix, Frobenius's norm.
    """

    values: Complexes
    right: Complexes
    left: Complexes
    conditions: Floats
    size: float


def general_eigen(A: Floats) -> Eigen:
    """Return eigenvalues and eigenvectors of a real matrix (n, n), by LAPACK, scaled by powers of two (Osborne 1960);
    numpy.linalg.LinAlgError where one does not converge, or A is not finite.

    Accuracy: those of a matrix that differs from the scaled one by 8 n eps of its size; so values within 8 n eps size
        conditions_k where that is small.
    """
    from scipy.linalg import eig, matrix_balance

    if not np.isfinite(A).all():
        raise np.linalg.LinAlgError("the matrix is not finite")
    B, (scale, _) = matrix_balance(A, permute=False, separate=True)
    unit = float(np.exp2(np.frexp(np.abs(B).max(initial=0.0))[1] - 1))  # LAPACK loses its own scale of large matrices
    values, left, right = (np.asarray(each, complex) for each in eig(B / unit, left=True))
    with np.errstate(divide="ignore"):
        conditions = 1.0 / np.abs((left.conj() * right).sum(axis=0))
    right, left = right * scale[:, None], left / scale[:, None]
    lengths = [np.linalg.norm(each, axis=0) for each in (right, left)]
    size = float(np.linalg.norm(B / unit)) * unit
    values *= unit
    return Eigen(values, right / lengths[0], left / lengths[1], conditions, size)
