"""Bodies whose moments are in books."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_samples import box, cone, cylinder, moved, tetrahedron, torus, uv_sphere

from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.triangles import MemoryTriangles

EPS = np.finfo(float).eps


def central(corners):
    """Volume, centre and inertia matrix about the centre at density 1."""
    found = integrate(MemoryTriangles("body", corners))
    offset = found.first / found.volume
    S = found.S - found.volume * np.outer(offset, offset)
    return found.volume, found.reference + offset, np.trace(S) * np.eye(3) - S


def normwise(found, expected, k=8):
    assert np.abs(found - np.asarray(expected)).max() <= k * EPS * np.abs(expected).max()


def test_mirtichs_tetrahedron():
    volume, centre, inertia = central(tetrahedron())
    normwise(volume, 10.0)
    normwise(centre, (1.25, 1.0, 0.75))
    normwise(inertia, [[9.375, 2.5, 1.875], [2.5, 12.75, 1.5], [1.875, 1.5, 15.375]])


def test_tonons_tetrahedron_to_the_printed_digits():
    corners = [(8.33220, -11.86875, 0.93355), (0.75523, 5, 16.37072), (52.61236, 5, -5.38580), (2, 5, 3)]
    _, centre, inertia = central(tetrahedron(corners))
    normwise(centre, np.mean(corners, axis=0))
    assert np.diagonal(inertia) == pytest.approx((43520.33329, 194711.29259, 191168.76489), rel=5e-8)
    products = sorted(np.abs(inertia[np.triu_indices(3, 1)]))
    assert products == pytest.approx((4417.66150, 11996.20119, 46343.16662), rel=5e-8)


def test_cube_of_edge_20():
    volume, _, inertia = central(box((20, 20, 20)))
    normwise(volume, 8000.0)
    normwise(inertia, 8000 * 400 / 6 * np.eye(3))


@pytest.mark.parametrize("offset", [(0, 0, 0), (7, -3, 0.125)])
def test_box(offset):
    a, b, c = sizes = np.array((0.375, 2.0, 0.0625))
    volume, centre, inertia = central(moved(box(sizes), offset))
    normwise(volume, a * b * c)
    assert (centre == offset).all()
    normwise(inertia, a * b * c / 12 * np.diag((b * b + c * c, a * a + c * c, a * a + b * b)))


def test_prism_on_a_regular_polygon():
    n, r, h = 47, 0.7, 1.9
    area = n / 2 * np.sin(2 * np.pi / n) * r**2
    across = area * h * r**2 / 12 * (2 + np.cos(2 * np.pi / n))
    along = area * h**3 / 12
    volume, _, inertia = central(cylinder(r, h, n))
    normwise(volume, area * h)
    normwise(inertia, np.diag((across + along, across + along, 2 * across)))


def test_pyramid_on_a_regular_polygon():
    n, r, h = 31, 0.4, 3.0
    volume, centre, _ = central(cone(r, h, n))
    normwise(volume, n / 2 * np.sin(2 * np.pi / n) * r**2 * h / 3)
    normwise(centre, (0, 0, h / 4))


@pytest.mark.parametrize("sectors", [64, 256])
def test_sphere_and_torus_are_approached_with_the_square_of_the_step(sectors):
    r, R = 0.5, 2.0
    volume, _, inertia = central(torus(R, r, sectors, sectors))
    exact = 2 * np.pi**2 * R * r**2
    step = (2 * np.pi / sectors) ** 2
    assert volume == pytest.approx(exact, rel=step / 2)
    side = (4 * R**2 + 5 * r**2) / 8
    assert inertia == pytest.approx(exact * np.diag((side, side, R**2 + 0.75 * r**2)), rel=step, abs=EPS * exact)
    volume, _, inertia = central(uv_sphere(r, sectors, sectors))
    exact = 4 / 3 * np.pi * r**3
    assert volume == pytest.approx(exact, rel=step / 2)
    assert inertia == pytest.approx(exact * 0.4 * r**2 * np.eye(3), rel=step, abs=EPS * exact)
