"""Mass properties placed, seen from other frames, scaled and refused, against sums over point masses in fractions."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from helpers.mass_clouds import floats, random_cloud, within
from helpers.oracles import EPS, worst
from hypothesis import given
from hypothesis import strategies as st

from robodyn.errors import InputError
from robodyn.programs.vectors import ZERO, rotation_from_rpy
from robodyn.solids.inertia.laws import exact, inertia_of
from robodyn.solids.inertia.properties import MassProperties
from robodyn.solids.inertia.solids import box

BITS = Fraction(1, 2**106)
angles = st.floats(-3, 3)
rotations = st.builds(rotation_from_rpy, angles, angles, angles)
places = st.tuples(*[st.floats(-1e8, 1e8)] * 3).map(np.array)
seeds = st.integers(0, 10**6)


@given(seeds, rotations, places)
def test_placed_is_rounded_once(seed, R, p):
    cloud = random_cloud(seed)
    there = cloud.placed(R, p)
    found = cloud.properties.placed(R, p)
    np.testing.assert_array_equal(found.com, floats(there.com))
    assert within(found.S_exact, there.second(there.com), BITS)
    assert found.mass == cloud.mass


@given(seeds, rotations, places)
def test_in_frame_undoes_placed(seed, R, p):
    body = random_cloud(seed).properties
    there = body.placed(R, p)
    back = there.in_frame(R, p)
    assert worst(back.S_c, body.S_c) <= 16 * EPS
    assert worst(back.com, body.com, np.abs(there.com).max() + np.abs(p).max()) <= 8 * EPS
    seen = body.in_frame(R, p)
    assert worst(seen.com, R.T @ (body.com - p), np.abs(body.com).max() + np.abs(p).max()) <= 8 * EPS
    assert worst(seen.inertia, R.T @ body.inertia @ R) <= 16 * EPS


@given(seeds, rotations, places, rotations, places)
def test_one_pose_after_another(seed, R1, p1, R2, p2):
    body = random_cloud(seed).properties
    stepwise = body.placed(R1, p1).placed(R2, p2)
    at_once = body.placed(R2 @ R1, R2 @ p1 + p2)
    assert worst(stepwise.S_c, at_once.S_c) <= 16 * EPS
    assert worst(stepwise.com, at_once.com, np.abs(p1).sum() + np.abs(p2).sum() + 1) <= 16 * EPS


@pytest.mark.parametrize("seed", range(20))
def test_about_any_point(seed):
    cloud = random_cloud(seed)
    body = cloud.properties
    for point in np.random.default_rng(seed).normal(size=(5, 3)):
        assert worst(body.about(point), floats(cloud.inertia(exact(point)))) <= 8 * EPS
    assert (np.abs(body.inertia - floats(cloud.inertia(cloud.com))) <= EPS * np.abs(body.inertia)).all()
    np.testing.assert_array_equal(body.about(body.com), body.inertia)


@given(seeds, rotations, st.tuples(*[st.floats(-3, 3)] * 3).map(np.array))
def test_moments_are_those_of_the_dynamics(seed, R, p):
    body = random_cloud(seed).properties
    found, expected = body.placed(R, p).moments, inertia_of(body.mass, body.com, body.inertia, R, p)
    assert found.m == expected.m
    assert worst(found.mc, expected.mc) <= 8 * EPS
    assert worst(found.I, expected.I) <= 16 * EPS


def test_rotated_and_moved_are_halves_of_placed():
    body, R, p = random_cloud(5).properties, rotation_from_rpy(0.1, 0.2, 0.3), np.array([1.0, 2.0, 3.0])
    np.testing.assert_array_equal(body.rotated(R).moved(p).S_exact, body.placed(R, p).S_exact)
    assert worst(body.rotated(R).moved(p).com, body.placed(R, p).com) <= EPS
    np.testing.assert_array_equal(body.moved(p).S_exact, body.S_exact)


@pytest.mark.parametrize("axis", range(3))
def test_a_plane_of_symmetry_makes_its_products_of_inertia_zero(axis):
    """The sum of a body and its mirror image, in any frame whose axis is the normal."""
    body = random_cloud(8).properties
    mirror = np.eye(3)
    mirror[axis, axis] = -1
    image = body.placed(mirror, ZERO)
    assert image.mass == body.mass
    both = body + image
    others = [k for k in range(3) if k != axis]
    assert not both.inertia[axis, others].any()
    assert both.com[axis] == 0
    assert body.inertia[axis, others].all()


@given(seeds, st.floats(1e-6, 1e6))
def test_scaled_to_a_mass(seed, mass):
    body = box(1, 2, 3, mass=1) + random_cloud(seed).properties
    scaled = body.scaled_to_mass(mass)
    assert scaled.mass == mass
    assert scaled.volume == body.volume
    np.testing.assert_array_equal(scaled.com, body.com)
    assert within(scaled.S_exact, body.S_exact * Fraction(mass) / Fraction(body.mass), BITS)


@pytest.mark.parametrize("exponent", [-60, -20, 20, 60])
def test_units_change_nothing_but_the_exponent(exponent):
    """No threshold is absolute: 2^-60 or 2^60 metres instead of one."""
    unit = 2.0**exponent
    cloud = random_cloud(11)
    R = rotation_from_rpy(0.4, 0.5, 0.6)
    body = cloud.properties.rotated(R)
    small = MassProperties(body.mass, body.com * unit, body.S_c * unit**2, S_low=body.S_low * unit**2)
    np.testing.assert_array_equal(small.principal.moments, body.principal.moments * unit**2)
    np.testing.assert_array_equal(small.principal.axes, body.principal.axes)
    np.testing.assert_array_equal((small + small.moved(small.com)).S_c, (body + body.moved(body.com)).S_c * unit**2)


def test_density_is_known_where_the_volume_is():
    assert box(1, 2, 3, mass=12).density == 2
    assert box(0, 2, 3, mass=12).density is None
    assert random_cloud(1).properties.density is None


def test_what_is_no_mass_property_is_refused():
    S = np.eye(3)
    with pytest.raises(InputError, match="not symmetric"):
        MassProperties(1.0, ZERO, S + np.triu(np.full((3, 3), 1e-11), 1))
    with pytest.raises(InputError, match=r"of shapes \(\(3,\), \(3,\), \(3, 3\)\), not"):
        MassProperties(1.0, ZERO, np.ones(3))
    for mass, com, moments in ((np.nan, ZERO, S), (1.0, ZERO + np.inf, S), (1.0, ZERO, S * np.nan)):
        with pytest.raises(InputError, match="infinite or not a number"):
            MassProperties(mass, com, moments)
    with pytest.raises(InputError, match="cannot be scaled"):
        MassProperties(0.0, ZERO, S).scaled_to_mass(1.0)
    with pytest.raises(InputError, match="exceeds"):
        MassProperties(1.0, ZERO, exact(S) * Fraction(10) ** 310)


def test_rounding_noise_in_the_symmetry_is_averaged():
    S = np.eye(3)
    S[0, 1] = 1e-13
    np.testing.assert_array_equal(MassProperties(1.0, ZERO, S).S_c, (S + S.T) / 2)


def test_holes_are_kept_as_they_are():
    S = -(np.eye(3) + 1)
    hole = MassProperties(-2.0, ZERO, S)
    np.testing.assert_array_equal(hole.S_c, S)
    np.testing.assert_array_equal((-hole).S_c, -S)
    assert (-box(1, 2, 3, mass=1)).volume == -6


def test_given_arrays_stay_the_callers_and_kept_ones_are_read_only():
    S, com = np.eye(3), np.zeros(3)
    body = MassProperties(1.0, com, S)
    S[0, 0], com[0] = 7, 7
    assert (body.S_c[0, 0], body.com[0]) == (1, 0)
    for kept in (body.S_c, body.S_low, body.com):
        with pytest.raises(ValueError, match="read-only"):
            kept[0] = 5
