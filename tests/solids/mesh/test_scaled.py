"""Triangles stretched along their axes, as <mesh scale="..."> of URDF asks for."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import mesh_samples

from robodyn.errors import MeshError
from robodyn.solids.mass_properties import mass_properties
from robodyn.solids.mesh.triangles import MemoryTriangles, scaled

EPS = np.finfo(float).eps
WEDGE = mesh_samples.tetrahedron()


def memory(corners=WEDGE):
    return MemoryTriangles("wedge", corners)


@pytest.mark.parametrize("factors", [(0.5, 2, 4), (1, -1, 1), (-1, -1, 3), (-2, -2, -2)])
def test_moments_are_those_of_the_stretched_body(factors):
    """V' = |det A| V, c' = A c, S' = |det A| A S A for A = diag(factors), mirror images included."""
    A, det = np.diag(factors), abs(np.prod(factors))
    before = mass_properties(WEDGE, density=1).body
    part = mass_properties(WEDGE, density=1, scale=factors)
    assert (part.closed, part.repairs) == (True, ())
    assert part.body.volume == pytest.approx(det * before.volume, rel=8 * EPS)
    np.testing.assert_allclose(part.body.com, A @ before.com, rtol=8 * EPS)
    expected = det * A @ before.S_c @ A
    np.testing.assert_allclose(part.body.S_c, expected, rtol=0, atol=32 * EPS * np.abs(expected).max())
    corners = WEDGE * factors
    np.testing.assert_array_equal((part.lo, part.hi), (corners.min(axis=(0, 1)), corners.max(axis=(0, 1))))


@pytest.mark.parametrize("factors", [(0, 1, 1), (1, np.nan, 1), (1, 1, np.inf)])
def test_refused(factors):
    with pytest.raises(MeshError, match="leaves no volume"):
        scaled(memory(), factors)


def test_a_part_in_millimetres_is_not_doubted():
    assert mass_properties(100 * WEDGE, scale=(0.001,) * 3).warnings == ()
    assert len(mass_properties(100 * WEDGE).warnings) == 1
