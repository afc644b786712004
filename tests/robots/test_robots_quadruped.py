"""The quadruped's motions by Pinocchio: feet that stand do not move."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.peers import pin
from helpers.robot_files import model, read_csv
from helpers.walked import LEGS, standing, states

MOTIONS = ("quadruped_stand", "quadruped_crouch", "quadruped_trot")
EPS = np.finfo(float).eps
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
            frame = robot.getFrameId(f"{LEGS[leg]}_foot")
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
