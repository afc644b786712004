"""Mass properties: laws, poses, conversions and refusals, against sums over point masses in fractions."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from helpers.mass_clouds import floats, random_cloud, within
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
    from_integrals,
    from_moments,
    from_surface_integrals,
    inertial_element,
)
from robodyn.solids.inertia.solids import box

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
