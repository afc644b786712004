from math import comb, factorial, prod

import numpy as np
import pytest
from helpers import mesh_samples as samples
from helpers.symmetric_bodies import any_rotation

from robodyn.solids.mesh.asymmetry import TriangleSet, axial_moments, central_moments

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


def test_rotation_turns_axial_moments():
    body = samples.moved(samples.tetrahedron(), (-1.0, -0.5, -0.2))
    angle = 0.7
    c, s = np.cos(angle), np.sin(angle)
    turned = samples.moved(body, R=[[c, -s, 0], [s, c, 0], [0, 0, 1]])
    phase = np.exp(1j * angle * np.arange(1, 9))[:, None]
    expected = axial_moments(body, np.eye(3), 10.0) * phase
    np.testing.assert_allclose(axial_moments(turned, np.eye(3), 10.0), expected, rtol=0, atol=1e-14)


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


def test_corner_moved_by_a_millionth_makes_it_another():
    body = samples.cylinder(sectors=12)
    both = np.concatenate([body, body * (1, 1, -1)])
    assert TriangleSet(both, 2.0).invariant(MIRROR)
    both[3, 1, 2] += 1e-6
    assert not TriangleSet(both, 2.0).invariant(MIRROR)


def test_triangle_that_is_there_twice_counts_twice():
    body = samples.cylinder(sectors=12)
    both = np.concatenate([body, body * (1, 1, -1), body[:1]])
    assert not TriangleSet(both, 2.0).invariant(MIRROR)
