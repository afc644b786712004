"""Eigenvalues and eigenvectors of general matrices in the same order of operations everywhere; see `linear`."""

from __future__ import annotations

import sys
from cmath import sqrt
from math import hypot
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import length, product
from robodyn.support.floats import Floats

Complexes = NDArray[np.complex128]
_EPS = sys.float_info.epsilon
_SWEEPS = 40
"""Per eigenvalue, of which two or three are needed; every tenth has another shift."""
_LARGE = 1e100


class Eigen(NamedTuple):
    """A right_k = value_k right_k and left_k^H A = value_k left_k^H, for the columns of right and left.

    Attributes:
        values: (n,), not sorted; those of a conjugate pair are conjugate within rounding.
        right, left: (n, n) unit columns.
        conditions: (n,) |left_k| |right_k| / |left_k^H right_k|: how far a change of the scaled matrix moves value_k.
        size: of the scaled matrix, Frobenius's norm.
    """

    values: Complexes
    right: Complexes
    left: Complexes
    conditions: Floats
    size: float


def general_eigen(A: Floats) -> Eigen:
    """Return eigenvalues and eigenvectors of a real matrix (n, n).

    Method: scaled by powers of two (Osborne 1960; Parlett, Reinsch 1969), to Hessenberg's form by Householder, then QR
    with Wilkinson's shift, in complex numbers (Golub, Van Loan, *Matrix Computations*, 7.5); vectors by substitution.

    Raises:
        numpy.linalg.LinAlgError: an eigenvalue does not converge, or A is not finite.

    Accuracy: those of a matrix that differs from the scaled one by 8 n eps of its size; so values within 8 n eps size
        conditions_k where that is small.
    """
    if not np.isfinite(A).all():
        raise np.linalg.LinAlgError("the matrix is not finite")
    scale = _balanced(A)
    B = A * scale / scale[:, None]
    unit = 2.0 ** np.frexp(np.abs(B).max(initial=0.0))[1]
    H, Q = _hessenberg(B / unit)
    T, Z = _triangular(H.astype(complex).tolist(), Q.astype(complex).tolist())
    right = _times(Z, _substituted(T))
    turned = [[T[j][i].conjugate() for j in reversed(range(len(T)))] for i in reversed(range(len(T)))]
    left = _times([row[::-1] for row in Z], _substituted(turned))[:, ::-1]
    right, left = (each / _lengths(each) for each in (right, left))
    along = np.abs((left.conj() * right).sum(axis=0))
    with np.errstate(divide="ignore"):
        conditions = 1.0 / along
    right, left = right * scale[:, None], left / scale[:, None]
    size = float(unit * length(H))
    values = np.array([T[k][k] for k in range(len(T))], dtype=complex) * unit
    return Eigen(values, right / _lengths(right), left / _lengths(left), conditions, size)


def _lengths(columns: Complexes) -> Floats:
    return np.asarray(np.sqrt((columns.real**2 + columns.imag**2).sum(axis=0)))


def _balanced(A: Floats) -> Floats:
    """Return d (n,), powers of two with rows and columns of A d_j / d_i about equally large."""
    d = np.ones(len(A))
    work = np.abs(A)
    np.fill_diagonal(work, 0.0)
    for _ in range(60):
        done = True
        for k in range(len(A)):
            row, column = float(work[k].sum()), float(work[:, k].sum())
            if row == 0.0 or column == 0.0:
                continue
            factor = 2.0 ** round(0.5 * float(np.log2(row / column)))
            if row / factor + column * factor < 0.95 * (row + column):
                done = False
                d[k] *= factor
                work[k] /= factor
                work[:, k] *= factor
        if done:
            break
    return d


def _hessenberg(A: Floats) -> tuple[Floats, Floats]:
    """Return H, zero below its first subdiagonal, and Q with A = Q H Q^T."""
    n = len(A)
    H, Q = A.copy(), np.eye(n)
    for k in range(n - 2):
        v = H[k + 1 :, k].copy()
        size = length(v)
        if not v[1:].any():
            continue
        v[0] += size if v[0] >= 0.0 else -size
        v /= length(v)
        H[k + 1 :] -= 2.0 * np.outer(v, product(v, H[k + 1 :]))
        H[:, k + 1 :] -= 2.0 * np.outer(product(H[:, k + 1 :], v), v)
        Q[:, k + 1 :] -= 2.0 * np.outer(product(Q[:, k + 1 :], v), v)
        H[k + 2 :, k] = 0.0
    return H, Q


def _triangular(T: list[list[complex]], Z: list[list[complex]]) -> tuple[list[list[complex]], list[list[complex]]]:
    """Return Schur's form T and Z of a Hessenberg matrix; NumPy's complex products depend on the processor."""
    last, tries = len(T) - 1, 0
    whole = max((abs(x) for row in T for x in row), default=0.0)
    while last > 0:
        first = last
        while first > 0 and not _negligible(T, first, whole):
            first -= 1
        if first > 0:
            T[first][first - 1] = 0j
        if first == last:
            last, tries = last - 1, 0
            continue
        tries += 1
        if tries > _SWEEPS:
            raise np.linalg.LinAlgError("an eigenvalue does not converge")
        shift = _shift(T, last) if tries % 10 else T[last][last] + abs(T[last][last - 1])
        _sweep(T, Z, first, last, shift)
    return T, Z


def _negligible(T: list[list[complex]], k: int, whole: float) -> bool:
    near = abs(T[k][k]) + abs(T[k - 1][k - 1])
    return abs(T[k][k - 1]) <= _EPS * (near or whole)


def _shift(T: list[list[complex]], k: int) -> complex:
    """Return the eigenvalue of the last two rows and columns that is nearer to the last entry (Wilkinson)."""
    a, b, c, d = T[k - 1][k - 1], T[k - 1][k], T[k][k - 1], T[k][k]
    half = 0.5 * (a - d)
    root = sqrt(half * half + b * c)
    below = half + root if abs(half + root) >= abs(half - root) else half - root
    return d - b * c / below if below else d


def _sweep(T: list[list[complex]], Z: list[list[complex]], first: int, last: int, shift: complex) -> None:
    """Replace T - shift = Q R by R Q on these rows, and Z by Z Q."""
    turns = []
    for k in range(first, last + 1):
        T[k][k] -= shift
    for k in range(first, last):
        x, y = T[k][k], T[k + 1][k]
        size = hypot(abs(x), abs(y))
        c, s = (x / size, y / size) if size else (1 + 0j, 0j)
        cc, ss = c.conjugate(), s.conjugate()
        upper, lower = T[k], T[k + 1]
        for j in range(k, len(T)):
            x, y = upper[j], lower[j]
            upper[j], lower[j] = cc * x + ss * y, c * y - s * x
        lower[k] = 0j
        turns.append((k, c, s, cc, ss))
    for k, c, s, cc, ss in turns:
        for row in (*T[: k + 2], *Z):
            x, y = row[k], row[k + 1]
            row[k], row[k + 1] = c * x + s * y, cc * y - ss * x
    for k in range(first, last + 1):
        T[k][k] += shift


def _substituted(T: list[list[complex]]) -> list[list[complex]]:
    """Return the eigenvectors of an upper triangle as rows; where two eigenvalues meet, one that is near."""
    n = len(T)
    smallest = _EPS * max((abs(x) for row in T for x in row), default=0.0) or 1.0
    out = []
    for k in range(n):
        x = [0j] * n
        x[k] = 1 + 0j
        for i in reversed(range(k)):
            row = T[i]
            gap = row[i] - T[k][k]
            right = sum((row[j] * x[j] for j in range(i + 1, k + 1)), 0j)
            x[i] = -right / (gap if abs(gap) > smallest else smallest)
            if abs(x[i]) > _LARGE:
                x = [entry / _LARGE for entry in x]
        out.append(x)
    return out


def _times(Z: list[list[complex]], rows: list[list[complex]]) -> Complexes:
    """Return Z X (n, n), of X given by its columns."""
    return np.array([[sum((z * x for z, x in zip(row, each, strict=True)), 0j) for each in rows] for row in Z])
