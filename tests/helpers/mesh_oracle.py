"""Moments of what triangles enclose in exact rationals, by a formula of their own: tetrahedra from the origin.

A tetrahedron 0, a, b, c has V = det(a, b, c) / 6, first moment V (a + b + c) / 4 and second moments
V (a a^T + b b^T + c c^T + s s^T) / 20 with s = a + b + c; the sums are then carried to a point by the parallel axis
theorem.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import lcm

import numpy as np


def exact(array):
    """The same numbers as fractions."""
    return np.array([Fraction(float(x)) for x in np.ravel(array)], dtype=object).reshape(np.shape(array))


def rational_moments(corners, reference):
    """V, first (3,) and second moments (3, 3) about the reference, as fractions; of a closed surface.

    Args:
        corners: (m, 3, 3) floats or fractions; reference: (3,) floats or fractions.
    """
    numbers, unit = _integers(corners)
    volume, first, second = 0, [0] * 3, [[0] * 3 for _ in range(3)]
    for a, b, c in numbers:
        D = a[0] * (b[1] * c[2] - b[2] * c[1]) + b[0] * (c[1] * a[2] - c[2] * a[1]) + c[0] * (a[1] * b[2] - a[2] * b[1])
        s = [sum(x) for x in zip(a, b, c, strict=True)]
        volume += D
        for i in range(3):
            first[i] += D * s[i]
        for i, j in product(range(3), repeat=2):
            second[i][j] += D * (a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + s[i] * s[j])
    V = unit**3 * volume / 6
    about_origin = np.array([unit**4 * x / 24 for x in first])
    S = np.array([[unit**5 * x / 120 for x in row] for row in second])
    r = np.array([Fraction(x) for x in reference], dtype=object)
    shifted = S - np.outer(about_origin, r) - np.outer(r, about_origin) + V * np.outer(r, r)
    return V, about_origin - V * r, shifted


def rational_moments_from(apex, corners):
    """The same about a point, by tetrahedra from there; of any surface."""
    return rational_moments(exact(corners) - exact(apex), (0, 0, 0))


def centred(volume, first, second):
    """Second moments about the centre."""
    return second - np.outer(first, first) / volume


def _integers(corners):
    """Triangles of integer corners, and the unit of which the coordinates are multiples."""
    ratios = [x.as_integer_ratio() for x in np.ravel(corners).tolist()]
    denominator = lcm(*(d for _, d in ratios))
    numbers = iter([n * (denominator // d) for n, d in ratios])
    triples = zip(numbers, numbers, numbers, strict=True)
    return list(zip(triples, triples, triples, strict=True)), Fraction(1, denominator)


def rotation(seed):
    """A generic rotation."""
    Q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return Q * np.sign(np.linalg.det(Q))


def deviation(found, expected):
    """The largest error, relative to the largest expected entry."""
    wanted = np.asarray(expected, dtype=object)
    error = np.max(np.abs(exact(found) - wanted))
    return float(error / np.max(np.abs(wanted)))
