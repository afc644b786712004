"""Closed forms of solids against integrals along their outlines; bodies fixed to each other, boxes of boxes, holes."""

from __future__ import annotations

from fractions import Fraction
from itertools import permutations

import mpmath
import numpy as np
import pytest
from helpers.mass_clouds import floats, joined, random_cloud, within
from helpers.oracles import EPS, worst
from hypothesis import given
from hypothesis import strategies as st

from robodyn.errors import InputError
from robodyn.programs.vectors import IDENTITY, ZERO, rotation_from_rpy
from robodyn.solids.inertia.properties import composite, from_inertia
from robodyn.solids.inertia.solids import box, capsule, cylinder, sphere

DENSITY = 2700.0
DIGITS = 60
"""mpmath's quadrature stops at an absolute error, and there are lengths of 1e-6 m to the fifth power."""


SIZES = [
    *((solid, sizes) for solid in (cylinder, capsule) for sizes in [(0.3, 0.7), (0.5, 1e-6), (1e-6, 2.0)]),
    *((sphere, (r,)) for r in (0.4, 1e-6)),
]


def _revolved(solid, r, length=0):
    """Volume, area, and second moments across and along of a solid of revolution about z, from its squared radius in
    parts along z: integrals of pi r^2, pi r^4 / 4 and pi r^2 z^2."""
    h = length / 2
    side = (-h, h, lambda z: r**2)
    caps = [(sign * h, sign * (h + r), lambda z: r**2 - (abs(z) - h) ** 2) for sign in (-1, 1)]
    parts = {cylinder: [side], sphere: caps, capsule: [side, *caps]}[solid]

    def total(integrand):
        pieces = [(min(start, end), max(start, end), square) for start, end, square in parts]
        return mpmath.pi * mpmath.fsum(mpmath.quad(lambda z, f=f: integrand(f(z), z), [a, b]) for a, b, f in pieces)

    area = 2 * mpmath.pi * r * (length + (r if solid is cylinder else 2 * r))
    return total(lambda s, z: s), area, total(lambda s, z: s**2 / 4), total(lambda s, z: s * z**2)


def _near(found, expected):
    return abs(found - expected) <= 8 * EPS * abs(expected)


@pytest.mark.parametrize(("solid", "sizes"), SIZES)
def test_solids_of_revolution(solid, sizes):
    body = solid(*sizes, density=DENSITY)
    with mpmath.workdps(DIGITS):
        volume, area, across, along = _revolved(solid, *map(mpmath.mpf, sizes))
        assert _near(body.volume, volume)
        assert _near(body.area, area)
        assert _near(body.mass, DENSITY * volume)
        assert _near(body.S_c[0, 0], DENSITY * across)
        assert _near(body.S_c[2, 2], DENSITY * along)
    assert body.S_c[1, 1] == body.S_c[0, 0]
    assert not (body.S_c - np.diag(np.diagonal(body.S_c))).any()
    assert not body.com.any()
    assert _near(body.density, DENSITY)


@pytest.mark.parametrize("solid", [box, cylinder, capsule, sphere])
def test_calls_that_are_wrong(solid):
    sizes = (3.0, 2.0, 1.0)[: {box: 3, sphere: 1}.get(solid, 2)]
    name = solid.__name__
    for neither_or_both in ({}, {"density": 1.0, "mass": 1.0}):
        with pytest.raises(InputError, match=f"a {name} needs either a density or a mass"):
            solid(*sizes, **neither_or_both)
    for bad in (-1.0, np.nan, np.inf):
        with pytest.raises(InputError, match=f"a {name} cannot have the length"):
            solid(*sizes[:-1], bad, mass=1.0)
    with pytest.raises(InputError, match="without volume has no mass"):
        solid(*(0.0 for _ in sizes), density=1.0)


BITS = Fraction(1, 2**106)


def _poses(seed, count, far=1.0):
    rng = np.random.default_rng(seed)
    return [(rotation_from_rpy(*rng.uniform(-3, 3, 3)), far * rng.normal(size=3)) for _ in range(count)]


@given(st.integers(0, 10**6), st.sampled_from([1.0, 1e4, 1e8]))
def test_the_sum_of_clouds_is_the_cloud_of_all_points(seed, far):
    clouds = [random_cloud(seed + k) for k in range(3)]
    poses = _poses(seed, 3, far)
    every = joined(*(cloud.placed(*pose) for cloud, pose in zip(clouds, poses, strict=True)))
    found = composite((cloud.properties, pose) for cloud, pose in zip(clouds, poses, strict=True))
    assert found.mass == every.mass
    np.testing.assert_array_equal(found.com, floats(every.com))
    assert within(found.S_exact, every.second(every.com), BITS)


def test_every_order_gives_the_same_bits():
    parts = [(random_cloud(k).properties, pose) for k, pose in enumerate(_poses(1, 4, 100.0))]
    results = [composite(some) for some in permutations(parts)]
    for other in results[1:]:
        assert other.mass == results[0].mass
        for name in ("com", "S_c", "S_low"):
            np.testing.assert_array_equal(getattr(other, name), getattr(results[0], name))


def test_a_hole_takes_away_what_its_plug_adds():
    plate = box(0.2, 0.1, 0.01, density=2700)
    plug = cylinder(0.02, 0.01, density=2700).placed(IDENTITY, np.array([0.05, 0.01, 0]))
    drilled = plate - plug
    assert drilled.mass == plate.mass - plug.mass
    assert drilled.volume == plate.volume - plug.volume
    assert drilled.area == plate.area + plug.area
    whole = drilled + plug
    assert abs(whole.mass - plate.mass) <= EPS * plate.mass
    assert worst(whole.S_c, plate.S_c) <= 4 * EPS
    assert np.abs(whole.com).max() <= EPS * 0.05
    assert drilled.com[0] < 0


def test_parts_without_mass_or_volume():
    ghost = from_inertia(0.0, ZERO, np.zeros((3, 3)))
    body = random_cloud(3).properties
    np.testing.assert_array_equal((body + ghost).S_exact, body.S_exact)
    assert composite(()).mass == 0
    assert not (ghost + ghost).com.any()
    with pytest.raises(InputError, match="add up to zero"):
        body - body.placed(IDENTITY, np.ones(3))
    with pytest.raises(InputError, match="not orthogonal"):
        composite([(body, (IDENTITY * 1.01, ZERO))])
    assert (body + box(1, 1, 1, mass=1)).volume is None
