"""The quadruped's motions by Pinocchio: feet that stand do not move, and two feet can carry the trot."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.peers import pin
from helpers.quadruped_motion import LEGS
from helpers.robot_files import model, read_csv
from helpers.walked import base_wrenches, standing, states

MOTIONS = ("quadruped_stand", "quadruped_crouch", "quadruped_trot")
EPS = np.finfo(float).eps
WEIGHT = 10 * 9.81
LARGEST = 50.0
"""rad/s^2, as a scale of accelerations."""


@pytest.fixture(scope="module")
def robot():
    return model("quadruped", pin.JointModelFreeFlyer())


@pytest.mark.parametrize("name", MOTIONS)
def test_feet_that_stand_stay_where_they_are(robot, name):
    table, data = read_csv(name), robot.createData()
    before = np.full((4, 3), np.nan)
    for row, on in zip(states(robot, table), standing(table), strict=True):
        pin.forwardKinematics(robot, data, *row)
        pin.updateFramePlacements(robot, data)
        for leg, stands in enumerate(on):
            frame = robot.getFrameId(f"{[*LEGS][leg]}_foot")
            place = data.oMf[frame].translation.copy()
            if not stands:
                assert place[2] >= -10 * EPS
                before[leg] = np.nan
                continue
            speed = pin.getFrameVelocity(robot, data, frame, pin.LOCAL_WORLD_ALIGNED).linear
            rate = pin.getFrameClassicalAcceleration(robot, data, frame, pin.LOCAL_WORLD_ALIGNED).linear
            assert abs(place[2]) <= 10 * EPS
            assert not np.abs(place - before[leg]).max() > 10 * EPS
            assert np.abs(speed).max() <= 20 * EPS
            assert np.abs(rate).max() <= 10 * EPS * LARGEST
            before[leg] = place


def test_two_feet_carry_the_trot(robot):
    """The resultant is a vertical force through the middle and a moment about it, which point feet can give."""
    table = read_csv("quadruped_trot")
    seen = set()
    for on, (place, f, m) in zip(standing(table), base_wrenches(robot, table), strict=True):
        seen.add(tuple(on))
        assert np.abs(place[:2]).max() == 0.0
        assert np.abs(f[:2]).max() <= 20 * EPS * WEIGHT
        assert np.abs(m[:2]).max() <= 20 * EPS * WEIGHT
        assert 0.3 * WEIGHT <= f[2] <= 2 * WEIGHT
        assert np.abs(m[2]) <= 0.5 * 0.6 * f[2] * 0.21
    assert seen == {(True,) * 4, (True, False, False, True), (False, True, True, False)}


@pytest.mark.parametrize("name", ["quadruped_stand", "quadruped_crouch"])
def test_the_centre_of_pressure_stays_between_the_feet(robot, name):
    for place, f, m in base_wrenches(robot, read_csv(name)):
        arm = np.cross([0, 0, 1], m + np.cross(place, f)) / f[2]
        assert np.abs(arm[:2]).max() <= 0.08
        assert f[2] >= 0.7 * WEIGHT
