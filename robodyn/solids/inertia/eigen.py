"""Eigenvalues of small symmetric matrices, the small ones as accurate as the large, in the same order of operations
everywhere: what LAPACK gives differs in the last digits from one processor to another."""

from __future__ import annotations

import sys
from itertools import combinations
from math import copysign, hypot, sqrt

import numpy as np

from robodyn.solids.inertia.exact import Floats

_EPS = sys.float_info.epsilon
_SWEEPS = 30


def eigen(S: Floats) -> tuple[Floats, Floats]:
    """Eigenvalues in descending order, and unit eigenvectors as rows: S = sum of s_i v_i v_i^T.

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
