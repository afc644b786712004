"""Mass properties from inertia matrices, moments about an origin, and integrals over volumes and surfaces."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from helpers.mass_clouds import random_cloud, within
from helpers.oracles import EPS, worst
from hypothesis import given
from hypothesis import strategies as st

from robodyn.errors import InputError
from robodyn.programs.vectors import ZERO, rotation_from_rpy
from robodyn.robot.load import load
from robodyn.robot.urdf.description import load_description
from robodyn.solids.inertia.laws import MASSLESS, exact
from robodyn.solids.inertia.properties import (
    from_inertia,
    from_integrals,
    from_moments,
    from_surface_integrals,
    inertial_element,
)
from robodyn.solids.inertia.solids import box, cone

BITS = Fraction(1, 2**106)
seeds = st.integers(0, 10**6)
TETRAHEDRON = np.array([(0, 0, 0), (5, 0, 0), (0, 4, 0), (0, 0, 3)])


def _integrals(corners):
    """Volume, integral of x and of x x^T over a tetrahedron, in fractions: V, V sum / 4, V (sum + sums) / 20."""
    v = exact(corners)
    a, b, c = v[1:] - v[0]
    V = abs(np.cross(a, b) @ c) / 6
    total = v.sum(axis=0)
    return V, V * total / 4, V * (v.T @ v + np.outer(total, total)) / 20


def test_the_tetrahedron_of_mirtich():
    V, first, second = _integrals(TETRAHEDRON)
    body = from_integrals(V, first, second, density=1.0)
    assert (body.mass, body.volume, body.area) == (10, 10, None)
    assert body.com.tolist() == [1.25, 1.0, 0.75]
    assert body.inertia.tolist() == [[9.375, 2.5, 1.875], [2.5, 12.75, 1.5], [1.875, 1.5, 15.375]]


def test_the_tetrahedron_of_tonon():
    corners = [(8.33220, -11.86875, 0.93355), (0.75523, 5, 16.37072), (52.61236, 5, -5.38580), (2, 5, 3)]
    V, first, second = _integrals(corners)
    I = from_integrals(V, first, second, density=1.0).inertia
    assert np.abs(np.diagonal(I) / [43520.33329, 194711.29259, 191168.76489] - 1).max() <= 5e-8


@given(seeds, st.sampled_from([Fraction(1, 1000), 0.001, 0.0254, 1.0, 1e6]), st.floats(1.0, 2e4))
def test_integrals_in_units_of_a_file(seed, scale, density):
    cloud = random_cloud(seed)
    reference = np.array([0.5, -3.0, 1e8])
    arms = cloud.masses @ cloud.points
    k, rho = Fraction(scale), Fraction(density)
    body = from_integrals(
        cloud.mass, arms, cloud.second(ZERO), density=density, reference=reference, scale=scale, area=7.0
    )
    assert body.mass == float(64 * rho * k**3)
    assert body.volume == float(64 * k**3)
    assert body.area == float(7 * k**2)
    np.testing.assert_array_equal(body.com, (k * (cloud.com + exact(reference))).astype(float))
    assert within(body.S_exact, rho * k**5 * cloud.second(cloud.com), BITS)


def test_integrals_about_any_reference_give_the_same_body():
    V, first, second = _integrals(TETRAHEDRON)
    r = exact([0.1, -7.3, 2.9])
    moved_first = first - V * r
    moved = second - np.outer(first, r) - np.outer(r, first) + V * np.outer(r, r)
    one = from_integrals(V, first, second, density=3.0)
    two = from_integrals(V, moved_first, moved, density=3.0, reference=r)
    np.testing.assert_array_equal(one.S_exact, two.S_exact)
    np.testing.assert_array_equal(one.com, two.com)


def test_a_shell_of_six_faces():
    """Against boxes of the shell's thickness t, which tend to it as t^2 / edge^2."""
    edge, t, density = 2.0, 1e-9, 500.0
    face = from_surface_integrals(4.0, ZERO, np.diag([4 / 3, 4 / 3, 0]), density=density, thickness=t)
    assert face.mass == pytest.approx(density * edge**2 * t, rel=2 * EPS)
    assert (face.volume, face.area) == (float(Fraction(t) * 4), 4.0)
    assert worst(face.inertia, box(edge, edge, t, density=density).inertia) <= 8 * EPS
    small = from_surface_integrals(
        4e6,
        [4e9, 0, 0],
        np.diag([4e12 / 3 + 4e12, 4e12 / 3, 0]),
        density=density,
        thickness=t,
        reference=[500.0, 7000.0, -250.0],
        scale=Fraction(1, 1000),
    )
    assert worst(small.inertia, face.inertia) <= 2 * EPS
    assert small.com.tolist() == [1.5, 7.0, -0.25]


@given(seeds)
def test_inertia_there_and_back(seed):
    cloud = random_cloud(seed, size=(1.0, 1e-3, 0.1))
    body = cloud.properties
    found = from_inertia(body.mass, body.com, body.inertia)
    assert worst(found.inertia, body.inertia) <= 2 * EPS
    assert worst(found.S_c, body.S_c) <= 2 * EPS
    whole = from_inertia(body.mass, body.com, cloud.inertia(cloud.com))
    assert within(whole.S_exact, body.S_exact, BITS)


@given(seeds, st.tuples(*[st.floats(-2, 2)] * 3).map(np.array))
def test_moments_there_and_back(seed, p):
    body = random_cloud(seed).properties.moved(p)
    moments = body.moments
    found = from_moments(moments)
    assert found.mass == body.mass
    assert worst(found.com, body.com) <= 2 * EPS
    assert worst(found.S_c, body.S_c, np.trace(moments.I)) <= 8 * EPS


def test_no_mass():
    body = from_moments(MASSLESS)
    assert (body.mass, body.com.any(), body.S_c.any()) == (0, False, False)


def test_shapes_without_volume_or_surface_are_refused():
    with pytest.raises(InputError, match="no volume"):
        from_integrals(0.0, ZERO, np.eye(3), density=1.0)
    with pytest.raises(InputError, match="no surface"):
        from_surface_integrals(0.0, ZERO, np.eye(3), density=1.0, thickness=1e-3)


def test_a_negative_volume_is_computed():
    """The signed integral of an inside-out mesh, which the caller has to judge."""
    V, first, second = _integrals(TETRAHEDRON)
    body = from_integrals(-V, -first, -second, density=1.0)
    assert (body.mass, body.volume) == (-10, -10)
    assert body.com.tolist() == [1.25, 1.0, 0.75]
    assert body.inertia[0, 0] == -9.375


def _urdf(body):
    return f'<robot name="r">\n  <link name="a">\n{inertial_element(body)}\n  </link>\n</robot>\n'.encode()


def test_the_text():
    body = box(1.0, 0.5, 0.25, mass=1.5).moved(np.array([0.1, -0.0, 1e-7]))
    assert inertial_element(body, indent="\t") == (
        "\t<inertial>\n"
        '\t  <origin xyz="0.1 0.0 1e-07" rpy="0 0 0"/>\n'
        '\t  <mass value="1.5"/>\n'
        '\t  <inertia ixx="0.0390625" ixy="0.0" ixz="0.0" iyy="0.1328125" iyz="0.0" izz="0.15625"/>\n'
        "\t</inertial>"
    )


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e-6])
def test_read_back_to_the_last_bit(seed, unit):
    body = random_cloud(seed, size=(unit, 2 * unit, unit / 3)).properties.placed(
        rotation_from_rpy(0.1 * seed, 0.2, 0.3), unit * np.array([1.0, 1 / 3, -1e-5])
    )
    inertial = load_description(_urdf(body)).links[0].inertial
    assert inertial.mass == body.mass
    assert inertial.origin.xyz == tuple(body.com)
    assert inertial.origin.rpy == (0, 0, 0)
    assert inertial.inertia == tuple(body.inertia[np.triu_indices(3)])


@pytest.mark.parametrize("seed", range(5))
def test_the_model_has_the_body(seed):
    body = random_cloud(seed).properties.rotated(rotation_from_rpy(1.0, 0.2, 0.3))
    found, expected = load(_urdf(body)).bodies[0].inertia, body.moments
    assert found.m == expected.m
    np.testing.assert_array_equal(found.mc, expected.mc)
    np.testing.assert_array_equal(found.I, expected.I)


def test_the_sign_of_the_products_of_inertia_is_that_of_the_matrix():
    """Mass where x y > 0 makes ixy negative."""
    S = np.eye(3)
    S[0, 1] = S[1, 0] = 0.5
    text = inertial_element(from_inertia(1.0, ZERO, np.trace(S) * np.eye(3) - S))
    assert 'ixy="-0.5"' in text


def test_bodies_off_their_centre():
    assert '<origin xyz="0.0 0.0 -0.25" rpy="0 0 0"/>' in inertial_element(cone(0.2, 1.0, mass=1))
