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
