"""The <inertial> element as text, read back by robodyn's own reader to the last bit."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mass_clouds import random_cloud

from robodyn.programs.vectors import ZERO, rotation_from_rpy
from robodyn.robot.load import load
from robodyn.robot.urdf.description import load_description
from robodyn.solids.inertia.properties import from_inertia, inertial_element
from robodyn.solids.inertia.solids import box, cone


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
