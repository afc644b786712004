"""The bound of Bhatia and Davis: reached by masses in corners, kept by bodies inside, broken by planted ones."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from helpers.mass_clouds import Cloud, floats, random_cloud
from helpers.oracles import EPS
from hypothesis import given
from hypothesis import strategies as st

from robodyn.errors import InputError
from robodyn.programs.vectors import IDENTITY, ZERO, rotation_from_rpy
from robodyn.solids.inertia.laws import exact
from robodyn.solids.inertia.properties import MassProperties, from_inertia
from robodyn.solids.inertia.solids import box
from robodyn.solids.inertia.validity import Box, around, box_bound, counted_twice, overlaps


def test_masses_in_the_corners_reach_it():
    """Whatever the centre of mass: a part w of the mass on one face and 1 - w on the other, for each axis."""
    lo, hi = np.array([-1.0, 2.0, 0.0]), np.array([3.0, 2.5, 8.0])
    shares = [(0.25, 0.75), (0.5, 0.5), (0.125, 0.875)]
    corners = [[(lo, hi)[k][axis] for axis, k in enumerate(choice)] for choice in product((0, 1), repeat=3)]
    masses = [np.prod([shares[axis][k] for axis, k in enumerate(choice)]) for choice in product((0, 1), repeat=3)]
    found = box_bound(Cloud(exact(masses), exact(corners)).properties, lo, hi)
    assert found.ratio.tolist() == [1.0, 1.0, 1.0]
    assert found.worst == 1.0
    assert found.spread.tolist() == [3.0, 0.0625, 7.0]


def test_a_uniform_box_takes_a_third_of_it():
    found = box_bound(box(1, 2, 3, mass=5).moved(np.array([1.0, 2, 3])), [0.5, 1, 1.5], [1.5, 3, 4.5])
    assert np.abs(found.ratio - 1 / 3).max() <= 8 * EPS


@given(st.integers(0, 10**6), st.integers(1, 8))
def test_every_body_inside_a_box_keeps_it(seed, points):
    cloud = random_cloud(seed, points)
    lo, hi = floats(cloud.points.min(axis=0)), floats(cloud.points.max(axis=0))
    assert box_bound(cloud.properties, lo, hi).worst <= 1 + 8 * EPS


@given(st.integers(0, 10**6))
def test_accuracy(seed):
    cloud = random_cloud(seed)
    lo, hi = np.full(3, -1.1), np.full(3, 1.3)
    found = box_bound(cloud.properties, lo, hi)
    bound = floats((exact(hi) - cloud.com) * (cloud.com - exact(lo)))
    spread = floats(np.diagonal(cloud.second(cloud.com)) / cloud.mass)
    assert (np.abs(found.bound - bound) <= 2 * EPS * (hi - lo) * 1.3).all()
    assert (np.abs(found.spread - spread) <= EPS * spread).all()


@pytest.mark.parametrize("axis", range(3))
def test_too_wide_a_body_is_found_in_its_axis(axis):
    """Second moments of a body whose inertia has been taken about the link's origin."""
    far = np.zeros(3)
    far[axis] = 2.0
    S = np.diagonal(box(1, 1, 1, mass=3).S_c) + 3 * far**2
    found = box_bound(MassProperties(3.0, ZERO, np.diag(S)), -IDENTITY.sum(0) / 2, IDENTITY.sum(0) / 2)
    assert found.worst == found.ratio[axis] > 16
    assert np.delete(found.ratio, axis).max() < 0.34


def test_a_centre_of_mass_outside_the_box():
    found = box_bound(box(1, 1, 1, mass=1).moved(np.array([0, 0, 0.75])), [-0.5] * 3, [0.5] * 3)
    assert found.ratio[2] == np.inf
    assert found.bound[2] == -0.3125
    assert found.ratio[0] < 1


def test_a_flat_box():
    flat = box(1, 1, 0, mass=1)
    assert box_bound(flat, [-0.5, -0.5, 0], [0.5, 0.5, 0]).ratio[2] == 0
    assert box_bound(box(1, 1, 1e-9, mass=1), [-0.5, -0.5, 0], [0.5, 0.5, 0]).ratio[2] == np.inf


def test_what_has_no_bound_is_refused():
    with pytest.raises(InputError, match="positive mass, not 0 kg"):
        box_bound(from_inertia(0.0, ZERO, IDENTITY), -np.ones(3), np.ones(3))
    with pytest.raises(InputError, match="wrong order"):
        box_bound(box(1, 1, 1, mass=1), np.ones(3), -np.ones(3))


UNIT = Box(np.zeros(3), np.ones(3))


def at(x, y=0.0, z=0.0):
    return UNIT.placed(IDENTITY, np.array([x, y, z]))


@pytest.mark.parametrize("seed", range(10))
def test_the_placed_box_is_the_smallest_around_the_corners(seed):
    rng = np.random.default_rng(seed)
    box = Box(-rng.random(3), rng.random(3))
    R, p = rotation_from_rpy(*rng.uniform(-3, 3, 3)), rng.normal(size=3)
    corners = np.array([[(box.lo, box.hi)[bits[i]][i] for i in range(3)] for bits in np.ndindex(2, 2, 2)])
    expected = corners @ R.T + p
    found = box.placed(R, p)
    np.testing.assert_allclose(found.lo, expected.min(axis=0), rtol=0, atol=1e-15)
    np.testing.assert_allclose(found.hi, expected.max(axis=0), rtol=0, atol=1e-15)


def test_around():
    found = around([at(0), at(2, -1)])
    np.testing.assert_array_equal((found.lo, found.hi), ([0, -1, 0], [3, 1, 1]))


@pytest.mark.parametrize(
    ("boxes", "pairs"),
    [
        ([UNIT], 0),
        ([UNIT, at(1)], 0),
        ([UNIT, at(1 - 1e-9)], 0),
        ([UNIT, at(0.99)], 1),
        ([UNIT, at(0.5, 2)], 0),
        ([UNIT, UNIT, UNIT], 3),
        ([UNIT, at(0.5), at(1.2)], 2),
    ],
)
def test_overlaps(boxes, pairs):
    assert overlaps(boxes) == pairs
    assert len(counted_twice(boxes)) == (pairs > 0)


def test_words():
    assert counted_twice([UNIT, UNIT]) == ("boxes of 1 pair of bodies overlap: what bodies share counts twice",)
    assert counted_twice([UNIT] * 3)[0].startswith("boxes of 3 pairs of bodies overlap")
    assert UNIT.placed(IDENTITY, ZERO).hi.tolist() == [1, 1, 1]
