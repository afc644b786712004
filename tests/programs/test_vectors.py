"""Vectors, rotations and moments of inertia against more digits, within the bounds that their docstrings state."""

from __future__ import annotations

import mpmath
import numpy as np
from helpers.oracles import EPS, worst
from hypothesis import given
from hypothesis import strategies as st

from robodyn.programs.vectors import (
    cross,
    rotation_about,
    rotation_from_quaternion,
    rotation_from_rpy,
    sign,
    skew,
    snapped,
)

angles = st.one_of(st.floats(-10, 10), st.sampled_from([k * np.pi / 2 for k in range(-8, 9)]), st.floats(-1e-12, 1e-12))
components = st.floats(-1, 1).filter(lambda x: x == 0 or abs(x) > 1e-6)
vectors = st.tuples(components, components, components).filter(lambda v: np.linalg.norm(v) > 0.1)


def _exact(function, *values):
    """The nine entries with 40 digits, rounded."""
    with mpmath.workdps(40):
        return np.array([[float(x) for x in row] for row in function(*(mpmath.mpf(float(x)) for x in values))])


def _about(x, y, z, t):
    n = mpmath.sqrt(x * x + y * y + z * z)
    a = [x / n, y / n, z / n]
    s, c = mpmath.sin(t), mpmath.cos(t)
    K = [[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]]
    return [[c * (i == j) + (1 - c) * a[i] * a[j] + s * K[i][j] for j in range(3)] for i in range(3)]


@given(vectors, angles)
def test_rotation_about_an_axis(axis, angle):
    unit = np.array(axis) / np.linalg.norm(axis)
    assert np.abs(rotation_about(unit, angle) - _exact(_about, *unit, angle)).max() <= 4 * EPS


def _of_rpy(roll, pitch, yaw):
    cr, sr, cp, sp, cy, sy = (f(x) for x in (roll, pitch, yaw) for f in (mpmath.cos, mpmath.sin))
    return [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]


@given(angles, angles, angles)
def test_rotation_from_rpy(roll, pitch, yaw):
    assert np.abs(rotation_from_rpy(roll, pitch, yaw) - _exact(_of_rpy, roll, pitch, yaw)).max() <= 4 * EPS


def _of_quaternion(x, y, z, w):
    n = x * x + y * y + z * z + w * w
    return [
        [(w * w + x * x - y * y - z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n],
        [2 * (x * y + w * z) / n, (w * w - x * x + y * y - z * z) / n, 2 * (y * z - w * x) / n],
        [2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n, (w * w - x * x - y * y + z * z) / n],
    ]


@given(vectors, components)
def test_rotation_from_a_quaternion_of_any_length(v, w):
    assert np.abs(rotation_from_quaternion(*v, w) - _exact(_of_quaternion, *v, w)).max() <= 8 * EPS


def test_snapped_moves_what_is_one_rounding_away_and_nothing_else():
    near = np.array([1 - EPS / 2, 1 + EPS, -1 + EPS / 2, EPS, -EPS, 1e-15, 0.5, -0.0])
    out = snapped(near)
    assert out.tolist() == [1.0, 1.0, -1.0, 0.0, 0.0, 1e-15, 0.5, 0.0]
    assert not np.signbit(out[[3, 4, 7]]).any()


def test_cross_and_skew_and_turns_about_coordinate_axes():
    expected = [[np.cos(0.3), 0, np.sin(0.3)], [0, 1, 0], [-np.sin(0.3), 0, np.cos(0.3)]]
    np.testing.assert_array_equal(rotation_about(np.eye(3)[1], 0.3), expected)
    assert [sign(x) for x in (3, np.float64(-2), 0)] == [1.0, -1.0, 0.0]
    a, b = np.random.default_rng(1).normal(size=(2, 3))
    assert worst(cross(a, b), skew(a) @ b) <= EPS
    assert worst(cross(a, b), np.cross(a, b)) <= EPS
