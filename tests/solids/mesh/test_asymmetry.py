"""What scores of symmetry are made of: columns, winding numbers, moments of higher order, sets of triangles."""

from __future__ import annotations

from math import comb, factorial, prod

import numpy as np
import pytest
from helpers import mesh_samples as samples
from helpers.mesh_samples import box, corners, flipped, moved, tetrahedron, torus, uv_sphere
from helpers.repaired_meshes import R
from helpers.symmetric_bodies import any_rotation

from robodyn.solids.mesh.asymmetry import TriangleSet, axial_moments, central_moments
from robodyn.solids.mesh.columns import Lattice, differing_volume
from robodyn.solids.mesh.indexed import merged
from robodyn.solids.mesh.inside import winding_numbers

ALONG = (0.0, 0.0, 1.0)
OBLIQUE = (0.36, 0.48, 0.8)


def test_integral_is_exact_in_depth():
    """Two boxes that differ by far less than the distance of the columns."""
    lattice = Lattice.over(samples.box((1, 2, 3.001)), np.array(ALONG))
    hits = [lattice.hits(samples.box((1, 2, 3 + d))) for d in (0.0, 1e-9)]
    assert differing_volume(*hits, lattice.cell) == pytest.approx(2e-9, rel=1e-3)
    assert differing_volume(hits[0], hits[0], lattice.cell) == 0.0


@pytest.mark.parametrize("offset", [(0.1, -0.2, 0.25), (9.0, 0.0, 0.0)])
def test_difference_of_a_box_and_the_same_moved(offset):
    one = samples.moved(samples.box(), R=any_rotation(4))
    other = samples.moved(samples.moved(samples.box(), offset), R=any_rotation(4))
    lattice = Lattice.over(np.concatenate([one, other]), np.array(OBLIQUE), count=100_000)
    shared = prod(max(0.0, 1 - abs(d)) for d in offset)
    found = differing_volume(lattice.hits(one), lattice.hits(other), lattice.cell)
    assert found == pytest.approx(2 - 2 * shared, rel=5e-3)


def numbers(triangles, *points):
    return winding_numbers(np.array(points, float), merged(triangles))


def test_a_side_of_a_cube_from_its_centre_and_a_corner_of_space_from_its_apex():
    assert numbers(moved(box()[:2], R=R), (0, 0, 0)) == pytest.approx([1 / 6], rel=1e-15)
    octant = corners([(1e9, 0, 0), (0, 1e9, 0), (0, 0, 1e9)], [(0, 1, 2)])
    assert numbers(octant, (0, 0, 0)) == pytest.approx([1 / 8], rel=1e-15)


@pytest.mark.parametrize("body", [box(), torus(0.6, 0.3), uv_sphere(0.7, 32, 64), tetrahedron() / 5 - 0.2])
def test_a_closed_surface_from_within_and_from_outside(body):
    points = np.random.default_rng(0).normal(size=(300, 3))
    points = points[(np.linalg.norm(points[:, None] - merged(body).vertices, axis=2) > 1e-2).all(axis=1)]
    found = numbers(body, *points)
    assert np.abs(found - np.rint(found)).max() < 1e-12
    assert set(np.rint(found)) == {0, 1}
    np.testing.assert_allclose(numbers(flipped(body), *points), -found, rtol=0, atol=1e-12)
    np.testing.assert_allclose(numbers(np.concatenate([body, body]), *points), 2 * found, rtol=0, atol=1e-12)


CORNER = samples.tetrahedron(((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)))


def monomial(powers):
    """The integral of x^a y^b z^c over the unit tetrahedron at the origin."""
    return prod(map(factorial, powers)) / factorial(sum(powers) + 3)


def test_moments_of_the_unit_tetrahedron():
    _, third, fourth = central_moments(CORNER, np.eye(3), 1 / 6).tensors
    for tensor in (third, fourth):
        for index in np.ndindex(tensor.shape):
            assert tensor[index] == pytest.approx(monomial([index.count(i) for i in range(3)]), rel=1e-14)


def test_axial_moments_of_the_unit_tetrahedron():
    found = axial_moments(CORNER, np.eye(3), 1 / 6)
    for m in range(1, 9):
        for k in range(3):
            powers = [(comb(m, j) * 1j**j, (m - j, j, k)) for j in range(m + 1)]
            expected = sum(factor * monomial(power) for factor, power in powers) * 6 if m + k <= 8 else 0.0
            assert abs(found[m - 1, k] - expected) <= 1e-14


def test_bound_is_zero_for_a_symmetry_and_positive_else():
    box = samples.box((1, 2, 3))
    moments = central_moments(box, np.diag([0.5, 2.0, 4.5]), 6.0)
    assert moments.least_asymmetry(np.diag([-1.0, 1.0, -1.0])) <= 1e-15
    assert 1e-3 < moments.least_asymmetry(any_rotation(3)) < 1


MIRROR = np.diag([1.0, 1.0, -1.0])


def test_turned_torus_is_the_same_set_whatever_the_order():
    R = any_rotation(6)
    body = samples.moved(samples.torus(rings=12), R=R)
    shuffled = np.roll(body[np.random.default_rng(0).permutation(len(body))], 1, axis=1)
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    assert TriangleSet(shuffled, 2.5).invariant(R @ turn @ R.T)
    assert not TriangleSet(shuffled, 2.5).invariant(R)


def test_a_corner_moved_by_a_millionth_or_a_triangle_twice_makes_it_another():
    body = samples.cylinder(sectors=12)
    both = np.concatenate([body, body * (1, 1, -1)])
    assert TriangleSet(both, 2.0).invariant(MIRROR)
    twice = np.concatenate([both, body[:1]])
    assert not TriangleSet(twice, 2.0).invariant(MIRROR)
    both[3, 1, 2] += 1e-6
    assert not TriangleSet(both, 2.0).invariant(MIRROR)
