"""Principal moments and axes; which mass properties a body, or a body in a box, can have."""

from __future__ import annotations

from itertools import product

import mpmath
import numpy as np
import pytest
from helpers.mass_clouds import Cloud, random_cloud
from helpers.oracles import EPS
from hypothesis import example, given
from hypothesis import strategies as st

from robodyn.errors import InputError
from robodyn.programs.vectors import IDENTITY, ZERO, rotation_about, rotation_from_quaternion, rotation_from_rpy
from robodyn.solids.inertia.laws import exact, rotation_law
from robodyn.solids.inertia.properties import MassProperties, from_inertia
from robodyn.solids.inertia.solids import box, cylinder
from robodyn.solids.inertia.validity import Box, box_bound, counted_twice, unphysical, validity

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


@pytest.mark.parametrize("seed", range(3))
def test_axes_are_orthonormal_right_handed_and_principal(seed):
    body = random_cloud(seed).properties
    p = body.principal
    assert p.remark is None
    assert (np.diff(p.moments) > 0).all()
    assert np.abs(p.axes @ p.axes.T - np.eye(3)).max() <= 8 * EPS
    assert abs(np.linalg.det(p.axes) - 1) <= 8 * EPS
    assert np.abs(p.axes @ body.inertia @ p.axes.T - np.diag(p.moments)).max() <= 16 * EPS * p.moments[2]
    assert all(axis[np.argmax(np.abs(axis))] > 0 for axis in p.axes[:2])


@pytest.mark.parametrize(("length", "order"), [(2.0, [2, 0, 1]), (0.1, [0, 1, 2])])
def test_axes_of_an_upright_cylinder_are_the_coordinate_axes(length, order):
    p = cylinder(0.5, length, mass=1).principal
    np.testing.assert_array_equal(p.axes, np.eye(3)[order])
    assert p.groups == (((0,), (1, 2)) if length == 2.0 else ((0, 1), (2,)))
    lone = 1 if length == 2.0 else 3
    assert f"every axis normal to axis {lone} = (0, 0, 1) is principal" in p.remark


@given(st.floats(-3, 3), st.floats(-1.5, 1.5), st.floats(-3, 3), st.floats(-3, 3), st.booleans())
def test_a_turn_about_the_axis_of_a_cylinder_does_not_show(roll, pitch, yaw, turn, slender):
    """Also where the axis is as far from two coordinate axes."""
    body = cylinder(0.5, 3.0 if slender else 0.3, mass=1)
    R = rotation_from_rpy(roll, pitch, yaw)
    one = body.placed(R, ZERO).principal
    two = body.placed(R @ rotation_about(np.array([0.0, 0, 1]), turn), ZERO).principal
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
    p = cylinder(0.1, 2.0, mass=1).placed(R, ZERO).principal
    assert np.abs(p.axes[0] - along).max() <= 8 * EPS
    assert np.abs(p.axes[1] - np.array([2.0, -1, -1]) / np.sqrt(6)).max() <= 8 * EPS


TURN = rotation_from_rpy(0.3, 0.5, 0.7)
angles = st.floats(-3, 3)


@given(st.integers(0, 10**6), st.integers(1, 6), st.sampled_from([1.0, 1e-6, 0.0]))
def test_bodies_of_positive_masses_are_physical(seed, points, thickness):
    body = random_cloud(seed, points, (1.0, 1.0, thickness)).properties.placed(TURN, ZERO)
    found = validity(body, relative=4 * EPS)
    assert found.faults == ()
    assert found.slack >= (-4 * EPS if thickness == 0 or points < 4 else 0)
    assert unphysical(body.inertia, relative=8 * EPS) is None


@example(0.75, 0.75, 0.03125, 0.0, 1.0, 1.5)  # 1.546875 is half-way between two numbers of six digits
@given(st.floats(0.001, 1), st.floats(0.001, 1), st.floats(1e-5, 1), angles, angles, angles)
def test_what_breaks_the_triangle_inequality_is_found_in_any_axes(one, two, excess, roll, pitch, yaw):
    """Also where the diagonal entries alone obey it."""
    I = rotation_law(np.diag([one, two, (one + two) * (1 + excess)]), rotation_from_rpy(roll, pitch, yaw))
    assert "break the triangle inequality" in unphysical(I)
    (fault,) = validity(from_inertia(1.0, ZERO, I)).faults
    assert fault == unphysical(I)


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_the_slack_is_relative(scale):
    assert unphysical(np.diag([1, 2, 3.0000029]) * scale) is None
    assert "triangle" in unphysical(np.diag([1, 2, 3.0000031]) * scale)
    assert unphysical(np.diag([1, 2, 3.0000031]) * scale, relative=1e-5) is None
    assert unphysical(np.diag([1, 1, -1e-7]) * scale) is None
    assert "negative" in unphysical(np.diag([1, 1, -1e-5]) * scale)
    for tensor in ([1, 2, 3.0000029], [1, 2, 3.0000031], [1, 1, -1e-7], [1, 1, -1e-5]):
        body = from_inertia(1.0, ZERO, np.diag(tensor) * scale)
        assert bool(validity(body).faults) == bool(unphysical(body.inertia))


def test_tensors_at_the_end_of_the_range():
    assert unphysical(np.diag([1.7e308, 1.7e308, 1.7e308])) is None
    assert "negative (-1.7e+308" in unphysical(np.diag([1.7e308, 1.7e308, -1.7e308]))
    assert unphysical(np.diag([2e-320, 2e-320, 2e-320])) is None


def test_all_faults_are_named():
    found = validity(from_inertia(-1.0, ZERO, np.diag([1.0, 1.0, -1.0])))
    assert [fault.split(" (")[0] for fault in found.faults] == [
        "the mass is not positive",
        "a principal moment of inertia is negative",
    ]
    assert found.slack == -1.0
    assert validity(from_inertia(0.0, ZERO, np.eye(3))).faults == ("the mass is not positive (0 kg)",)
    np.testing.assert_array_equal(found.moments, [-1.0, 1.0, 1.0])


def test_masses_in_the_corners_reach_it():
    """Whatever the centre of mass: a part w of the mass on one face and 1 - w on the other, for each axis."""
    lo, hi = np.array([-1.0, 2.0, 0.0]), np.array([3.0, 2.5, 8.0])
    shares = [(0.25, 0.75), (0.5, 0.5), (0.125, 0.875)]
    corners = [[(lo, hi)[k][axis] for axis, k in enumerate(choice)] for choice in product((0, 1), repeat=3)]
    masses = [np.prod([shares[axis][k] for axis, k in enumerate(choice)]) for choice in product((0, 1), repeat=3)]
    body = Cloud(exact(masses), exact(corners)).properties
    assert box_bound(body, lo, hi).tolist() == [1.0, 1.0, 1.0]
    assert np.diagonal(body.S_c).tolist() == [3.0, 0.0625, 7.0]


def test_too_wide_a_body_a_centre_of_mass_outside_the_box_and_a_flat_box():
    """Too wide: second moments of a body whose inertia has been taken about the link's origin."""
    unit = [-0.5] * 3, [0.5] * 3
    S = np.diagonal(box(1, 1, 1, mass=3).S_c) + 3 * np.array([0.0, 4.0, 0.0])
    found = box_bound(MassProperties(3.0, ZERO, np.diag(S)), *unit)
    assert found[1] > 16
    assert np.delete(found, 1).max() < 0.34
    found = box_bound(box(1, 1, 1, mass=1).placed(IDENTITY, np.array([0, 0, 0.75])), *unit)
    assert found[2] == np.inf
    assert found[0] < 1
    flat = [-0.5, -0.5, 0], [0.5, 0.5, 0]
    assert [box_bound(box(1, 1, z, mass=1), *flat)[2] for z in (0, 1e-9)] == [0, np.inf]


def test_what_has_no_bound_is_refused():
    with pytest.raises(InputError, match="positive mass, not 0 kg"):
        box_bound(from_inertia(0.0, ZERO, IDENTITY), -np.ones(3), np.ones(3))
    with pytest.raises(InputError, match="wrong order"):
        box_bound(box(1, 1, 1, mass=1), np.ones(3), -np.ones(3))


UNIT = Box(np.zeros(3), np.ones(3))


def at(x, y=0.0, z=0.0):
    return UNIT.placed(IDENTITY, np.array([x, y, z]))


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
    which = "1 pair of bodies overlap" if pairs == 1 else f"{pairs} pairs of bodies overlap"
    assert counted_twice(boxes) == ((f"boxes of {which}: what bodies share counts twice",) if pairs else ())
