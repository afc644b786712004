"""The trajectories of robots/: generated bit for bit, consistent with themselves, within the limits of their robots."""

from __future__ import annotations

import make_robots
import numpy as np
import pytest
from helpers.robot_files import FOLDER, FULL, MOTORS_ONLY, read_csv
from helpers.sampled import sampled

import robodyn
from robodyn.robot.urdf.description import load_description
from robodyn.scene.read import load_scene
from robodyn.scene.scene import Scene

MOVED_BY_JOINTS = sorted({**FULL, **MOTORS_ONLY})


def _limits(name):
    return {joint.name: joint for joint in load_description(FOLDER / f"{(FULL | MOTORS_ONLY)[name]}.urdf").joints}


def _joints(table):
    return [column[3:] for column in table if column.startswith("qd_")]


@pytest.mark.parametrize("name", sampled(make_robots.TRAJECTORIES))
def test_regenerated_bit_for_bit(name):
    assert make_robots.text(make_robots.TRAJECTORIES[name]).encode() == (FOLDER / name).read_bytes()


@pytest.mark.parametrize("name", MOVED_BY_JOINTS)
def test_within_position_and_velocity_limits_and_every_joint_moves(name):
    table, limits = read_csv(name), _limits(name)
    for joint in _joints(table):
        q, qd = table[f"q_{joint}"], table[f"qd_{joint}"]
        assert np.abs(qd).max() <= limits[joint].limit.velocity
        assert np.abs(qd).max() >= 0.1 * limits[joint].limit.velocity
        if limits[joint].type != "continuous":
            assert limits[joint].limit.lower <= q.min()
            assert q.max() <= limits[joint].limit.upper


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
