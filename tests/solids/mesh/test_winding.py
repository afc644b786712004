"""Winding numbers: solid angles that are known, whole numbers within closed surfaces, and the sum of parts."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_samples import box, corners, flipped, moved, tetrahedron, torus, uv_sphere
from helpers.repaired_meshes import R

from robodyn.solids.mesh.indexed import Indexed, merged
from robodyn.solids.mesh.inside import winding_numbers


def numbers(triangles, *points):
    return winding_numbers(np.array(points, float), merged(triangles))


def test_a_side_of_a_cube_from_its_centre_and_a_corner_of_space_from_its_apex():
    assert numbers(moved(box()[:2], R=R), (0, 0, 0)) == pytest.approx([1 / 6], rel=1e-15)
    octant = corners([(1e9, 0, 0), (0, 1e9, 0), (0, 0, 1e9)], [(0, 1, 2)])
    assert numbers(octant, (0, 0, 0)) == pytest.approx([1 / 8], rel=1e-15)


def test_a_cube_without_a_side_from_the_middle_of_that_side():
    assert numbers(moved(box()[2:], R=R), R @ (-0.5, 0, 0)) == pytest.approx([0.5], abs=1e-15)


@pytest.mark.parametrize("body", [box(), torus(0.6, 0.3), uv_sphere(0.7, 32, 64), tetrahedron() / 5 - 0.2])
def test_a_closed_surface_from_within_and_from_outside(body):
    points = np.random.default_rng(0).normal(size=(300, 3))
    points = points[(np.linalg.norm(points[:, None] - merged(body).vertices, axis=2) > 1e-2).all(axis=1)]
    found = numbers(body, *points)
    assert np.abs(found - np.rint(found)).max() < 1e-12
    assert set(np.rint(found)) == {0, 1}
    np.testing.assert_allclose(numbers(flipped(body), *points), -found, rtol=0, atol=1e-12)
    np.testing.assert_allclose(numbers(np.concatenate([body, body]), *points), 2 * found, rtol=0, atol=1e-12)


def test_close_to_a_triangle_the_side_decides():
    side = moved(box()[:2], R=R)
    near = [R @ (-0.5 + distance, 0.1, 0.2) for distance in (1e-6, -1e-6)]
    assert numbers(side, *near) == pytest.approx([0.5, -0.5], abs=1e-5)


def test_blocks_of_points_and_vertices_out_of_use_change_nothing():
    mesh = merged(torus(rings=96, sectors=96))
    points = np.random.default_rng(1).normal(size=(50, 3))
    whole = winding_numbers(points, mesh)
    part = Indexed(mesh.vertices, mesh.faces[:4000])
    rest = Indexed(mesh.vertices, mesh.faces[4000:])
    np.testing.assert_allclose(winding_numbers(points, part) + winding_numbers(points, rest), whole, rtol=0, atol=1e-12)


def test_nothing_has_no_winding_number():
    nothing = Indexed(np.zeros((1, 3)), np.empty((0, 3), np.int64))
    assert winding_numbers(np.ones((2, 3)), nothing).tolist() == [0, 0]
