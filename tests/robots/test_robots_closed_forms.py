"""The parameters of robots/ against the closed forms and printed torques that their headers state."""

from __future__ import annotations

import json
from decimal import Decimal

import numpy as np
import pytest
from helpers.closed_forms import TORQUES
from helpers.peers import pin
from helpers.robot_files import REFERENCE, model, torques
from helpers.scene_files import read_scene

EPS = np.finfo(float).eps


def _states(n, seed=7):
    return np.random.default_rng(seed).uniform(-1.5, 1.5, (3, 50, n))


@pytest.mark.parametrize("name", TORQUES)
def test_torques(name):
    q, qd, qdd = _states(model(name).nv)
    expected = TORQUES[name](q, qd, qdd)
    tau = torques(model(name), q, qd, qdd)
    np.testing.assert_allclose(tau, np.column_stack(expected), rtol=0, atol=40 * EPS * np.abs(expected).max())


def test_satellite_inertia_about_the_bus_frame():
    robot = model("satellite", pin.JointModelFreeFlyer())
    data = robot.createData()
    for q1, q2 in _states(2)[0]:
        M = pin.crba(robot, data, np.array([0, 0, 0, 0, 0, 0, 1, q1, q2]))
        s, c = np.sin([q1, q2]), np.cos([q1, q2])
        bus = robot.inertias[1]
        expected = bus.inertia + bus.mass * (bus.lever @ bus.lever * np.eye(3) - np.outer(bus.lever, bus.lever))
        expected[0, 0] += np.sum(20 * 1.5**2 + 8 * c**2 + 8.4 * s**2)
        expected[1, 1] += 2 * 0.5
        expected[2, 2] += np.sum(20 * 1.5**2 + 8 * s**2 + 8.4 * c**2)
        expected[[0, 2], [2, 0]] += np.sum(0.4 * s * c)
        np.testing.assert_allclose(M[3:6, 3:6], expected, rtol=0, atol=20 * EPS * expected.max())


def test_composite_is_the_sum_of_its_solids():
    total, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for mass, place, turn, moments in _composite_parts():
        total += mass
        first += mass * np.array(place)
        second += turn @ np.diag(moments) @ turn.T + mass * (np.dot(place, place) * np.eye(3) - np.outer(place, place))
    whole = model("composite").inertias[0]
    centre = first / total
    about_centre = second - total * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    assert whole.mass == pytest.approx(total, rel=4 * EPS)
    np.testing.assert_allclose(whole.lever, centre, rtol=0, atol=4 * EPS)
    np.testing.assert_allclose(whole.inertia, about_centre, rtol=0, atol=20 * EPS * about_centre.max())
    assert abs(whole.lever[1]) <= EPS
    assert np.abs(whole.inertia[[0, 1], [1, 2]]).max() <= 4 * EPS * about_centre.max()


def _composite_parts():
    """Mass, centre, rotation and principal moments of every solid, from the dimensions in the header."""
    flat, upright = np.eye(3), pin.utils.rotate("x", np.pi / 2)
    yield 12, (0, 0, 0), flat, _box(12, 0.6, 0.4, 0.02)
    yield 6, (0.1, 0, 0.26), flat, _cylinder(6, 0.05, 0.5)
    yield 1.2, (-0.22, 0, 0.15), pin.utils.rotate("y", 0.6), _box(1.2, 0.3, 0.01, 0.2)
    yield 4, (0.2, 0, 0.09), flat, [2 / 5 * 4 * 0.08**2] * 3
    for side in (1, -1):
        yield 3, (-0.2, side * 0.22, 0), upright, _cylinder(3, 0.12, 0.04)
        yield 1.5, (0.2, side * 0.25, -0.035), pin.utils.rotate("z", side * 0.5), _box(1.5, 0.3, 0.05, 0.05)


def _box(m, a, b, c):
    return [m * (b * b + c * c) / 12, m * (c * c + a * a) / 12, m * (a * a + b * b) / 12]


def _cylinder(m, r, L):
    return [m * (3 * r * r + L * L) / 12] * 2 + [m * r * r / 2]


@pytest.mark.parametrize("case", [1, 3])
def test_puma560_with_motors_gives_the_published_torques(case):
    text = (REFERENCE / "published_checks.json").read_text()
    published = json.loads(text, parse_float=Decimal)["puma560_rtb"]["cases"][case]
    qd, qdd = np.full(6, float(published["qd"])), np.full(6, float(published["qdd"]))
    tau = torques(model("puma560"), [[0, np.pi / 4, np.pi, 0, np.pi / 4, 0]], [qd], [qdd])[0] + motors(qd, qdd)
    for ours, printed in zip(tau, published["tau"], strict=True):
        half_a_digit = 0.5 * 10.0 ** Decimal(printed).as_tuple().exponent if printed else 0.5e-4
        assert abs(ours - float(printed)) <= half_a_digit


def motors(qd, qdd):
    """Torque of rotors and friction of puma560_motors.toml, forward."""
    scene, names = read_scene("puma560_motors"), model("puma560").names[1:]
    armature = np.array([scene["rotor"][name]["gear"] ** 2 * scene["rotor"][name]["inertia"] for name in names])
    viscous, forward = ([scene["friction"][name][key] for name in names] for key in ("viscous", "coulomb"))
    return armature * qdd + np.array(viscous) * qd + np.array(forward)[:, 0] * (qd > 0)
