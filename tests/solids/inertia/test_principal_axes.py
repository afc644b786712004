"""Principal moments of plates and needles in any pose, directions and degeneracy of the axes."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from helpers.mass_clouds import random_cloud
from helpers.oracles import EPS
from hypothesis import given
from hypothesis import strategies as st

from robodyn.programs.vectors import rotation_about, rotation_from_quaternion, rotation_from_rpy
from robodyn.solids.inertia.laws import inertia_matrix
from robodyn.solids.inertia.principal import principal_axes
from robodyn.solids.inertia.solids import box, cylinder, sphere

SHAPES = {
    "plate": (1.0, 0.8, 1e-6),
    "needle": (1.0, 1e-6, 2e-6),
    "thread": (1.0, 1e-10, 3e-10),
    "strip": (1.0, 1e-3, 1e-6),
    "brick": (0.3, 0.2, 0.1),
}


def _turns(count):
    rng = np.random.default_rng(4)
    return [rotation_from_quaternion(*(q / np.linalg.norm(q))) for q in rng.normal(size=(count, 4))]


def _moments_of(edges, mass):
    """Principal moments of a box, ascending, with 40 digits."""
    with mpmath.workdps(40):
        x, y, z = (mpmath.mpf(edge) ** 2 * mass / 12 for edge in edges)
        return sorted((y + z, z + x, x + y))


@pytest.mark.parametrize("shape", SHAPES)
def test_every_principal_moment_in_any_pose(shape):
    """Within 32 eps of the box's closed form, which is what the rotations differ from orthogonal ones.

    Each entry of the second moments is kept to 2^-106 of its size, and a moment k^2 times smaller to 2^-104 k^2.
    """
    body = box(*SHAPES[shape], mass=3.0)
    bound = 32 * EPS + 2.0**-104 * (max(SHAPES[shape]) / min(SHAPES[shape])) ** 2
    assert shape == "thread" or bound < 1e-14
    expected = _moments_of(SHAPES[shape], 3)
    for R in (np.eye(3), *_turns(6)):
        found = body.placed(R, np.array([5.0, -7.0, 11.0])).principal.moments
        assert all(abs(f - e) <= bound * e for f, e in zip(found, expected, strict=True))


@pytest.mark.parametrize("seed", range(6))
def test_axes_are_orthonormal_right_handed_and_principal(seed):
    body = random_cloud(seed).properties
    p = body.principal
    assert p.unique
    assert p.remark is None
    assert (np.diff(p.moments) > 0).all()
    assert np.abs(p.axes @ p.axes.T - np.eye(3)).max() <= 8 * EPS
    assert abs(np.linalg.det(p.axes) - 1) <= 8 * EPS
    assert np.abs(p.axes @ body.inertia @ p.axes.T - np.diag(p.moments)).max() <= 16 * EPS * p.moments[2]
    assert all(axis[np.argmax(np.abs(axis))] > 0 for axis in p.axes[:2])


@pytest.mark.parametrize("seed", range(3))
def test_axes_do_not_depend_on_how_they_are_reached(seed):
    """A body and the same body turned by half turns about its axes have the same axes, signs and all."""
    body = random_cloud(seed).properties
    for axis in body.principal.axes:
        turned = body.rotated(rotation_about(axis, np.pi)).principal
        gap = np.diff(body.principal.moments).min() / body.principal.moments[2]
        assert np.abs(turned.axes - body.principal.axes).max() <= 64 * EPS / gap


@pytest.mark.parametrize(("length", "order"), [(2.0, [2, 0, 1]), (0.1, [0, 1, 2])])
def test_axes_of_an_upright_cylinder_are_the_coordinate_axes(length, order):
    p = cylinder(0.5, length, mass=1).principal
    np.testing.assert_array_equal(p.axes, np.eye(3)[order])
    assert not p.unique
    assert p.groups == (((0,), (1, 2)) if length == 2.0 else ((0, 1), (2,)))
    lone = 1 if length == 2.0 else 3
    assert f"every axis normal to axis {lone} = (0, 0, 1) is principal" in p.remark


@given(st.floats(-3, 3), st.floats(-1.5, 1.5), st.floats(-3, 3), st.floats(-3, 3), st.booleans())
def test_a_turn_about_the_axis_of_a_cylinder_does_not_show(roll, pitch, yaw, turn, slender):
    """Also where the axis is as far from two coordinate axes."""
    body = cylinder(0.5, 3.0 if slender else 0.3, mass=1)
    R = rotation_from_rpy(roll, pitch, yaw)
    one = body.rotated(R).principal
    two = body.rotated(R @ rotation_about(np.array([0.0, 0, 1]), turn)).principal
    assert one.groups == two.groups
    lone = 0 if slender else 2
    assert np.abs(one.axes[lone] - two.axes[lone]).max() <= 64 * EPS
    size = np.sort(np.abs(one.axes[lone]))
    if size[1] - size[0] > 1e-8:
        assert np.abs(one.axes - two.axes).max() <= 64 * EPS / np.sqrt(1 - size[0] ** 2)
    assert abs(np.linalg.det(one.axes) - 1) <= 16 * EPS


def test_ties_go_to_the_first_axis():
    along = np.ones(3) / np.sqrt(3)
    R = rotation_about(np.array([-1.0, 1.0, 0]) / np.sqrt(2), np.arccos(1 / np.sqrt(3)))
    assert np.abs(R[:, 2] - along).max() <= 4 * EPS
    p = cylinder(0.1, 2.0, mass=1).rotated(R).principal
    assert np.abs(p.axes[0] - along).max() <= 8 * EPS
    assert np.abs(p.axes[1] - np.array([2.0, -1, -1]) / np.sqrt(6)).max() <= 8 * EPS


def test_a_ball_has_the_coordinate_axes_in_any_pose():
    for R in _turns(5):
        p = sphere(0.2, mass=2).rotated(R).principal
        assert p.groups == ((0, 1, 2),)
        np.testing.assert_array_equal(p.axes, np.eye(3))
        assert p.remark == "all principal moments are equal within 1e-09: every axis is principal"


@pytest.mark.parametrize("tolerance", [1e-9, 1e-4])
def test_axes_of_equal_moments_are_principal_within_the_tolerance(tolerance):
    for R in _turns(10):
        body = box(1.0, 1.0 + 0.5 * tolerance, 3.0, mass=1).rotated(R)
        p = principal_axes(body.S_c, body.S_low, tolerance)
        assert len(p.groups) == 2
        off = p.axes @ inertia_matrix(body.S_c) @ p.axes.T - np.diag(p.moments)
        assert np.abs(off).max() <= (tolerance + 32 * EPS) * p.moments[2]


def test_no_inertia_at_all():
    p = principal_axes(np.zeros((3, 3)))
    assert p.groups == ((0, 1, 2),)
    assert not p.moments.any()
