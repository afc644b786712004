"""Inertia matrices and matrices of second moments, each from the other."""

from __future__ import annotations

import numpy as np

from robodyn.programs.vectors import Array
from robodyn.solids.inertia.exact import Floats


def inertia_matrix(S: Floats) -> Floats:
    """I = tr(S) 1 - S, the inertia matrix of second moments S = integral of x x^T dm about the same point.

    Diagonal entries are written as sums of two, so that those of a needle keep their digits.

    Accuracy: each entry within eps / 2.
    """
    I = 0.0 - S
    for i in range(3):
        I[i, i] = S[i - 1, i - 1] + S[i - 2, i - 2]
    return I


def principal_moments(second: Floats) -> Floats:
    """I_1 = s_2 + s_3, I_2 = s_1 + s_3, I_3 = s_1 + s_2: ascending, of second moments along principal axes descending.

    Accuracy: each within eps / 2.
    """
    return np.array([second[i - 2] + second[i - 1] for i in range(3)])


def second_moments(I: Array) -> Array:
    """S = tr(I) / 2 1 - I, the inverse of `inertia_matrix`.

    Exact for fractions. Floats lose the digits of a second moment that is small against the moments of inertia.

    Accuracy: each entry within 2 eps of the largest moment of inertia.
    """
    half = I / 2
    S: Array = 0 * I - I
    for i in range(3):
        S[i, i] = half[i - 1, i - 1] + half[i - 2, i - 2] - half[i, i]
    return S
