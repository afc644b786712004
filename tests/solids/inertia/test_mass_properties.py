"""Mass properties: laws, poses, conversions and refusals, against sums over point masses in fractions; closed forms of
solids against integrals along their outlines; bodies fixed to each other, holes."""

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
from robodyn.robot.load import load, load_description
from robodyn.solids.inertia.laws import (
    MASSLESS,
    about_centre,
    exact,
    orthogonal,
    parallel_axis,
)
from robodyn.solids.inertia.properties import (
    MassProperties,
    composite,
    from_inertia,
    from_integrals,
    from_moments,
    from_surface_integrals,
    inertial_element,
)
from robodyn.solids.inertia.solids import box, capsule, cylinder, sphere

places = st.tuples(*[st.floats(-10, 10)] * 3).map(np.array)
angles = st.floats(-3, 3)
rotations = st.builds(rotation_from_rpy, angles, angles, angles)
far_places = st.tuples(*[st.floats(-1e8, 1e8)] * 3).map(np.array)
seeds = st.integers(0, 10**6)
BITS = Fraction(1, 2**106)


def _terms(I, m, d):
    """What the parallel axis theorem adds up, in magnitudes."""
    d = np.abs(d)
    return np.abs(I) + abs(m) * (d @ d * np.eye(3) + np.outer(d, d))


@given(seeds, places)
def test_parallel_axis_theorem_both_ways(seed, point):
    cloud = random_cloud(seed)
    m, com = float(cloud.mass), floats(cloud.com)
    about_com, about_point = cloud.inertia(cloud.com), cloud.inertia(exact(point))
    assert worst(cloud.properties.about(point), floats(about_point)) <= 8 * EPS
    d = com - point
    bound = 16 * EPS * _terms(floats(about_com), m, np.abs(com) + np.abs(point))
    assert (np.abs(parallel_axis(floats(about_com), m, d) - floats(about_point)) <= bound).all()
    assert (np.abs(parallel_axis(floats(about_com), m, -d) - floats(about_point)) <= bound).all()
    bound = 16 * EPS * _terms(floats(about_point), m, np.abs(com) + np.abs(point))
    assert (np.abs(about_centre(floats(about_point), m, d) - floats(about_com)) <= bound).all()


@pytest.mark.parametrize("R", [np.eye(2), np.full((3, 3), np.nan), np.eye(3) + 1e-8])
def test_what_is_no_rotation_is_refused(R):
    with pytest.raises(InputError, match="not orthogonal: R R\\^T differs from 1 by"):
        orthogonal(R)
    mirror = np.diag([1.0, -1.0, 1.0])
    assert orthogonal(mirror) is mirror


@given(seeds, rotations, far_places)
def test_placed_is_rounded_once(seed, R, p):
    cloud = random_cloud(seed)
    there = cloud.placed(R, p)
    found = cloud.properties.placed(R, p)
    np.testing.assert_array_equal(found.com, floats(there.com))
    assert within(found.S_exact, there.second(there.com), BITS)
    assert found.mass == cloud.mass


@given(seeds, st.floats(1e-6, 1e6))
def test_scaled_to_a_mass(seed, mass):
    body = box(1, 2, 3, mass=1) + random_cloud(seed).properties
    scaled = body.scaled_to_mass(mass)
    assert scaled.mass == mass
    assert scaled.volume == body.volume
    np.testing.assert_array_equal(scaled.com, body.com)
    assert within(scaled.S_exact, body.S_exact * Fraction(mass) / Fraction(body.mass), BITS)


def test_what_is_no_mass_property_is_refused():
    S = np.eye(3)
    S[0, 1] = 1e-13
    np.testing.assert_array_equal(MassProperties(1.0, ZERO, S).S_c, (S + S.T) / 2)
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


def test_given_arrays_stay_the_callers_and_kept_ones_are_read_only():
    S, com = np.eye(3), np.zeros(3)
    body = MassProperties(1.0, com, S)
    S[0, 0], com[0] = 7, 7
    assert (body.S_c[0, 0], body.com[0]) == (1, 0)
    for kept in (body.S_c, body.S_low, body.com):
        with pytest.raises(ValueError, match="read-only"):
            kept[0] = 5


@given(seeds, st.sampled_from([Fraction(1, 1000), 0.001, 0.0254, 1.0, 1e6]), st.floats(1.0, 2e4))
def test_integrals_in_units_of_a_file(seed, scale, density):
    cloud = random_cloud(seed)
    reference = np.array([0.5, -3.0, 1e8])
    arms = cloud.masses @ cloud.points
    k, rho = Fraction(scale), Fraction(density)
    body = from_integrals(cloud.mass, arms, cloud.second(ZERO), density=density, reference=reference, scale=scale)
    assert body.mass == float(64 * rho * k**3)
    assert body.volume == float(64 * k**3)
    np.testing.assert_array_equal(body.com, (k * (cloud.com + exact(reference))).astype(float))
    assert within(body.S_exact, rho * k**5 * cloud.second(cloud.com), BITS)


def test_a_shell_of_six_faces():
    """Against boxes of the shell's thickness t, which tend to it as t^2 / edge^2."""
    edge, t, density = 2.0, 1e-9, 500.0
    face = from_surface_integrals(4.0, ZERO, np.diag([4 / 3, 4 / 3, 0]), density=density, thickness=t)
    assert face.mass == pytest.approx(density * edge**2 * t, rel=2 * EPS)
    assert (face.volume, face.area) == (float(Fraction(t) * 4), 4.0)
    assert worst(face.inertia, box(edge, edge, t, density=density).inertia) <= 8 * EPS
    S, far = np.diag([4e12 / 3 + 4e12, 4e12 / 3, 0]), [500.0, 7000.0, -250.0]
    small = from_surface_integrals(
        4e6, [4e9, 0, 0], S, density=density, thickness=t, reference=far, scale=Fraction(1, 1000)
    )
    assert worst(small.inertia, face.inertia) <= 2 * EPS
    assert small.com.tolist() == [1.5, 7.0, -0.25]


@given(seeds, st.tuples(*[st.floats(-2, 2)] * 3).map(np.array))
def test_moments_there_and_back(seed, p):
    body = random_cloud(seed).properties.placed(IDENTITY, p)
    moments = body.moments
    found = from_moments(moments)
    assert found.mass == body.mass
    assert worst(found.com, body.com) <= 2 * EPS
    assert worst(found.S_c, body.S_c, np.trace(moments.I)) <= 8 * EPS
    assert from_moments(MASSLESS).mass == 0


def test_shapes_without_volume_or_surface_are_refused():
    with pytest.raises(InputError, match="no volume"):
        from_integrals(0.0, ZERO, np.eye(3), density=1.0)
    with pytest.raises(InputError, match="no surface"):
        from_surface_integrals(0.0, ZERO, np.eye(3), density=1.0, thickness=1e-3)


def _urdf(body):
    return f'<robot name="r">\n  <link name="a">\n{inertial_element(body)}\n  </link>\n</robot>\n'.encode()


def test_the_text():
    body = box(1.0, 0.5, 0.25, mass=1.5).placed(IDENTITY, np.array([0.1, -0.0, 1e-7]))
    assert inertial_element(body) == (
        "<inertial>\n"
        '  <origin xyz="0.1 0.0 1e-07" rpy="0 0 0"/>\n'
        '  <mass value="1.5"/>\n'
        '  <inertia ixx="0.0390625" ixy="0.0" ixz="0.0" iyy="0.1328125" iyz="0.0" izz="0.15625"/>\n'
        "</inertial>"
    )


@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e-6])
def test_read_back_to_the_last_bit(unit):
    """By the reader and by the model; mass where x y > 0 makes ixy negative."""
    for seed in range(4):
        body = random_cloud(seed, size=(unit, 2 * unit, unit / 3)).properties.placed(
            rotation_from_rpy(0.1 * seed, 0.2, 0.3), unit * np.array([1.0, 1 / 3, -1e-5])
        )
        inertial = load_description(_urdf(body)).links[0].inertial
        assert inertial.mass == body.mass
        assert inertial.origin.xyz == tuple(body.com)
        assert inertial.origin.rpy == (0, 0, 0)
        assert inertial.inertia == tuple(body.inertia[np.triu_indices(3)])
    body = random_cloud(1).properties.placed(rotation_from_rpy(1.0, 0.2, 0.3), ZERO)
    found = load(_urdf(body)).bodies[0].inertia
    assert all(np.array_equal(one, other) for one, other in zip(found, body.moments, strict=True))
    assert np.sign(body.inertia[0, 1]) == -np.sign(body.S_c[0, 1])


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
