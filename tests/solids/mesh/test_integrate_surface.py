"""Moments of surfaces."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_oracle import exact, rotation
from helpers.mesh_samples import box, cylinder, flipped, moved, sheet, torus, uv_sphere

from robodyn.solids.mesh.integrals import surface
from robodyn.solids.mesh.triangles import MemoryTriangles

EPS = np.finfo(float).eps
BODIES = {"box": box((1, 2, 3)), "sphere": uv_sphere(0.5, 6, 8), "torus": torus(2, 0.5, 12, 8)}


def integrals(array):
    return surface(MemoryTriangles("sheet", array))


def reference_moments(corners, reference):
    """The same sums with 40 digits, the middles of edges being replaced by corners and centre."""
    from mpmath import mp, mpf

    with mp.workdps(40):
        area, first, second = mpf(0), np.zeros(3, object), np.zeros((3, 3), object)
        for a, b, c in exact(corners) - exact(reference):
            normal = np.cross(b - a, c - a)
            square = sum(normal * normal)
            size = mp.sqrt(mpf(square.numerator) / square.denominator) / 2
            s = a + b + c
            quadratic = sum(np.outer(v, v) for v in (a, b, c, s)) / 12
            area += size
            first = first + size * _mp(s / 3, mpf)
            second = second + size * _mp(quadratic, mpf)
    return area, first, second


def _mp(array, mpf):
    return np.vectorize(lambda x: mpf(x.numerator) / x.denominator, otypes=[object])(array)


def off(found, expected):
    """The largest error, relative to the largest expected entry."""
    wanted = np.asarray(expected, dtype=object)
    return float(np.max(np.abs(found - wanted)) / np.max(np.abs(wanted)))


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("offset", [0, 1e8])
def test_within_1e15_wherever_the_origin_is(body, offset):
    array = moved(BODIES[body], (0.6 * offset, -offset, 0.8 * offset), rotation(3))
    found = integrals(array)
    A, first, S = reference_moments(array, found.reference)
    assert off(found.area, A) <= 1e-15
    assert off(found.S, S) <= 1e-15
    assert np.max(np.abs(found.first - first)) <= 1e-15 * A * np.ptp(array)


def test_box():
    a, b, c = 1.0, 2.0, 3.0
    found = integrals(moved(box((a, b, c)), (5, 6, 7)))
    assert found.area == 2 * (a * b + b * c + c * a)
    assert (found.reference + found.first / found.area == (5, 6, 7)).all()
    along_x = (b * c) * a * a / 2 + (a * b + a * c) * a * a / 6
    assert found.S[0, 0] == pytest.approx(along_x, rel=4 * EPS)
    assert np.abs(found.S - np.diag(np.diagonal(found.S))).max() <= 4 * EPS * found.S.max()


def test_flat_sheet():
    found = integrals(sheet(2.0, 3.0))
    assert found.area == 6.0
    assert np.abs(found.S - np.diag((2.0, 4.5, 0.0))).max() <= 4 * EPS * 4.5


def test_side_of_a_cylinder_of_many_sectors():
    r, h, n = 0.5, 4.0, 400
    found = integrals(cylinder(r, h, n)[n:-n])
    assert found.area == pytest.approx(2 * n * np.sin(np.pi / n) * r * h, rel=4 * EPS)
    assert found.S[2, 2] == pytest.approx(found.area * h * h / 12, rel=4 * EPS)


def test_winding_does_not_matter():
    array = BODIES["torus"]
    found, expected = integrals(np.concatenate([flipped(array[:50]), array[50:]])), integrals(array)
    assert found.area == pytest.approx(expected.area, rel=4 * EPS)
    assert np.abs(found.S - expected.S).max() <= 4 * EPS * expected.S.max()
