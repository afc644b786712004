"""Vectors, rotations and moments of inertia against more digits, within the bounds that their docstrings state."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from helpers.oracles import EPS, worst
from hypothesis import given
from hypothesis import strategies as st

from robodyn.dynamics.recursions.newton_euler import euler
from robodyn.programs.vectors import (
    cross,
    rotation_about,
    rotation_from_quaternion,
    rotation_from_rpy,
    sign,
    skew,
    snapped,
)
from robodyn.solids.inertia.laws import MASSLESS, combined, inertia_of

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


def _random_body(rng):
    spread = rng.normal(size=(3, 3))
    return rng.uniform(0.1, 3), rng.normal(size=3), spread @ spread.T


@pytest.mark.parametrize("seed", range(5))
def test_inertia_of_a_displaced_body(seed):
    rng = np.random.default_rng(seed)
    m, c, I_c = _random_body(rng)
    R, p = rotation_about(np.array([0.6, 0, 0.8]), rng.normal()), rng.normal(size=3)
    found = inertia_of(m, c, I_c, R, p)
    with mpmath.workdps(40):
        exact = [mpmath.matrix(x.tolist()) for x in (R, I_c)]
        r = exact[0] * mpmath.matrix(c.tolist()) + mpmath.matrix(p.tolist())
        I = exact[0] * exact[1] * exact[0].T
        square = sum(x * x for x in r)
        moment = [[float(I[i, j] + m * (square * (i == j) - r[i] * r[j])) for j in range(3)] for i in range(3)]
        first = [float(m * x) for x in r]
    lengths = np.abs(R) @ np.abs(c) + np.abs(p)
    magnitude = np.abs(R) @ np.abs(I_c) @ np.abs(R.T) + m * (lengths @ lengths * np.eye(3) + np.outer(lengths, lengths))
    assert (np.abs(found.I - moment) <= 16 * EPS * magnitude).all()
    assert (np.abs(found.mc - first) <= 16 * EPS * m * lengths).all()
    assert found.m == m
    assert worst(found.centre_of_mass, np.array(first) / m) <= 4 * EPS


@pytest.mark.parametrize("seed", range(5))
def test_eulers_equations_entry_by_entry(seed):
    """Against I wd + w x I w with 40 digits, within 8 eps (|I| |wd| + |I| |w|^2)."""
    rng = np.random.default_rng(seed)
    I = _random_body(rng)[2]
    w, wd = rng.normal(size=(2, 3)) * 10 ** rng.uniform(-3, 3, (2, 1))
    with mpmath.workdps(40):
        exact, spin = mpmath.matrix(I.tolist()), mpmath.matrix(w.tolist())
        h = exact * spin
        gyro = [spin[1] * h[2] - spin[2] * h[1], spin[2] * h[0] - spin[0] * h[2], spin[0] * h[1] - spin[1] * h[0]]
        push = exact * mpmath.matrix(wd.tolist())
        expected = np.array([float(push[i] + gyro[i]) for i in range(3)])
    size = np.linalg.norm(I, 2)
    bound = 8 * EPS * size * (np.linalg.norm(wd) + np.linalg.norm(w) ** 2)
    assert np.abs(euler(I, w, wd) - expected).max() <= bound


def test_moments_add_up():
    rng = np.random.default_rng(3)
    one, two = inertia_of(*_random_body(rng)), inertia_of(*_random_body(rng))
    both = combined((one, two))
    assert both.m == one.m + two.m
    np.testing.assert_array_equal(both.I, one.I + two.I)
    assert (combined(()).m, combined(()).I.any(), MASSLESS.centre_of_mass.any()) == (0, False, False)
