"""Parallel axis theorem, rotation law and second moments against sums over point masses in fractions."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from helpers.mass_clouds import floats, random_cloud
from helpers.oracles import EPS, worst
from hypothesis import given
from hypothesis import strategies as st

from robodyn.errors import InputError
from robodyn.programs.vectors import rotation_from_rpy
from robodyn.solids.inertia.laws import (
    about_centre,
    exact,
    fraction,
    inertia_matrix,
    orthogonal,
    parallel_axis,
    rotation_law,
    rounded,
    second_moments,
    two_floats,
)

lengths = st.floats(-10, 10)
places = st.tuples(lengths, lengths, lengths).map(np.array)
angles = st.floats(-3, 3)
rotations = st.builds(rotation_from_rpy, angles, angles, angles)


def _terms(I, m, d):
    """What the parallel axis theorem adds up, in magnitudes."""
    d = np.abs(d)
    return np.abs(I) + abs(m) * (d @ d * np.eye(3) + np.outer(d, d))


@given(st.integers(0, 10**6), places)
def test_parallel_axis_theorem_both_ways(seed, point):
    cloud = random_cloud(seed)
    m, com = float(cloud.mass), floats(cloud.com)
    about_com, about_point = cloud.inertia(cloud.com), cloud.inertia(exact(point))
    d = com - point
    bound = 16 * EPS * _terms(floats(about_com), m, np.abs(com) + np.abs(point))
    assert (np.abs(parallel_axis(floats(about_com), m, d) - floats(about_point)) <= bound).all()
    assert (np.abs(parallel_axis(floats(about_com), m, -d) - floats(about_point)) <= bound).all()
    bound = 16 * EPS * _terms(floats(about_point), m, np.abs(com) + np.abs(point))
    assert (np.abs(about_centre(floats(about_point), m, d) - floats(about_com)) <= bound).all()


@pytest.mark.parametrize("seed", range(20))
def test_the_moment_about_any_axis_is_least_through_the_centre_of_mass(seed):
    rng = np.random.default_rng(seed)
    body = random_cloud(seed).properties
    for d in rng.normal(size=(20, 3)):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        more = axis @ (body.about(body.com + d) - body.inertia) @ axis
        arm = np.linalg.norm(np.cross(axis, d))
        assert more > 0
        assert abs(more - body.mass * arm**2) <= 64 * EPS * np.trace(body.about(body.com + d))


@given(st.integers(0, 10**6), rotations)
def test_rotation_law(seed, R):
    cloud = random_cloud(seed)
    I = floats(cloud.inertia(cloud.com))
    exactly = exact(R) @ exact(I) @ exact(R).T
    bound = 16 * EPS * (np.abs(R) @ np.abs(I) @ np.abs(R).T)
    assert (np.abs(rotation_law(I, R) - floats(exactly)) <= bound).all()
    assert worst(rotation_law(rotation_law(I, R), R.T), I) <= 64 * EPS
    assert abs(np.trace(rotation_law(I, R)) - np.trace(I)) <= 16 * EPS * np.trace(I)
    turned = cloud.placed(R, np.zeros(3))
    assert worst(rotation_law(I, R), floats(turned.inertia(turned.com))) <= 16 * EPS


@pytest.mark.parametrize("seed", range(20))
def test_inertia_and_second_moments_from_each_other(seed):
    cloud = random_cloud(seed, size=(1.0, 1e-6, 1e-3))
    S, I = cloud.second(cloud.com), cloud.inertia(cloud.com)
    assert (second_moments(I) == S).all()
    assert (np.abs(inertia_matrix(floats(S)) - floats(I)) <= EPS * np.abs(floats(I))).all()
    assert np.abs(second_moments(floats(I)) - floats(S)).max() <= 2 * EPS * np.abs(floats(I)).max()


@pytest.mark.parametrize(
    "R", [np.eye(3) * 1.1, np.diag([1.0, 1, 0]), np.eye(2), np.full((3, 3), np.nan), np.eye(3) + 1e-8]
)
def test_what_is_no_rotation_is_refused(R):
    with pytest.raises(InputError, match="not orthogonal: R R\\^T differs from 1 by"):
        orthogonal(R)


def test_reflections_are_orthogonal():
    mirror = np.diag([1.0, -1.0, 1.0])
    assert orthogonal(mirror) is mirror


def test_every_kind_of_number_is_taken_as_it_is():
    third = Fraction(1, 3)
    assert exact([0.1, 2, third]).tolist() == [Fraction(3602879701896397, 2**55), 2, third]
    assert fraction(np.float32(0.1)) == Fraction(13421773, 2**27)
    wide = np.longdouble(1) + np.finfo(np.longdouble).eps
    assert fraction(wide) == 1 + Fraction(*np.finfo(np.longdouble).eps.as_integer_ratio())
    assert exact(np.eye(2, dtype=int)).shape == (2, 2)


@given(st.fractions(min_value=-(10**9), max_value=10**9).filter(lambda x: abs(x) > Fraction(1, 10**100)))
def test_two_floats_hold_106_bits(number):
    high, low = two_floats(np.array([number], dtype=object))
    assert high.dtype == low.dtype == float
    assert high[0] == float(number)
    assert abs(fraction(high[0]) + fraction(low[0]) - number) <= abs(number) / 2**106


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused(bad):
    with pytest.raises(InputError, match="infinite or not a number"):
        exact([1.0, bad])


def test_what_is_too_large_for_a_float_is_refused():
    with pytest.raises(InputError, match=r"exceeds 1\.8e308"):
        rounded(np.array([Fraction(10) ** 309], dtype=object))
