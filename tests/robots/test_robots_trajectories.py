"""The trajectories of robots/: consistent with themselves, within the limits of their robots."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.robot_files import FOLDER, FULL, MOTORS_ONLY, read_csv

import robodyn
from robodyn.robot.load import load_description
from robodyn.scene.read import load_scene
from robodyn.scene.scene import Scene

MOVED_BY_JOINTS = {**FULL, **MOTORS_ONLY}
KNOTS = 40
"""Rows of a motion at most, near which its jerk jumps."""


def _joints(table):
    return [column[3:] for column in table if column.startswith("qd_")]


def test_rates_are_those_of_positions():
    """By a rule of quadrature that is exact to degree 6."""
    for name in (*MOVED_BY_JOINTS, "quadruped_stand", "quadruped_crouch", "quadruped_trot"):
        table = read_csv(name)
        h = table["time"][1]
        for joint in _joints(table):
            q, qd, qdd = (table[f"{level}_{joint}"] for level in ("q", "qd", "qdd"))
            rule = h / 15 * (7 * qd[:-2] + 16 * qd[1:-1] + 7 * qd[2:]) + h * h / 15 * (qdd[:-2] - qdd[2:])
            off = np.sort(np.abs(q[2:] - q[:-2] - rule))
            assert off[-KNOTS] <= 1e-9
            assert off[-1] <= 2e-5


def test_within_position_and_velocity_limits_and_every_joint_moves():
    for name, robot in MOVED_BY_JOINTS.items():
        table, limits = read_csv(name), {each.name: each for each in load_description(FOLDER / f"{robot}.urdf").joints}
        for joint in _joints(table):
            q, qd, limit = table[f"q_{joint}"], table[f"qd_{joint}"], limits[joint].limit
            assert 0.1 * limit.velocity <= np.abs(qd).max() <= limit.velocity
            assert limits[joint].type == "continuous" or (limit.lower <= q.min() and q.max() <= limit.upper)


@pytest.mark.parametrize("name", sorted(set(FULL) - {"satellite_slew", "gripper_pick"}))
def test_within_effort_limits(name):
    scene = load_scene(FOLDER / "puma560_motors.toml") if name == "puma560_sweep" else Scene()
    model = robodyn.load(FOLDER / f"{FULL[name]}.urdf")
    with robodyn.read_motion(FOLDER / f"{name}.csv", model, scene, ignore_extra=True) as motion:
        found = robodyn.torques(model, motion, scene)
    assert [each for each in found.exceeded if each.quantity == "effort"] == []
    assert all(joint.effort_limit for joint in found.joints)


def test_waves_and_encoder_are_the_same_motion():
    waves, encoder = read_csv("puma_waves"), read_csv("puma_encoder")
    step = 2 * np.pi / 2**17
    np.testing.assert_array_equal(waves["t"][:200], encoder["t"][::5])
    for joint in ("waist", "shoulder", "elbow"):
        counts = encoder[joint] / step
        np.testing.assert_allclose(counts, np.round(counts), rtol=0, atol=1e-10)
        assert np.abs(encoder[joint][::5] - waves[joint][:200]).max() <= 0.5 * step * (1 + 1e-9)
