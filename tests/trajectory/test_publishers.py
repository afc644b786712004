"""Logs whose joints come in messages of several publishers on one topic."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.command_line import ROBOTS

import robodyn
from robodyn.errors import TrajectoryError
from robodyn.trajectory.motion import join
from robodyn.trajectory.read import signals
from robodyn.trajectory.reader import TrajectoryReader
from robodyn.trajectory.readers.messages import NANO, LogTable, State
from robodyn.trajectory.reading import Reading, hold_of

ROBOT = ROBOTS / "two_link_planar.urdf"
STEP = 8_000_000
"""ns."""


def angle(stamps):
    return np.sin(2e-9 * np.asarray(stamps))


def publisher(names, stamps, position=angle):
    """Messages whose joints all have the same position, and that times 3 for a torque."""
    values = position(stamps)
    return [
        State(int(t), tuple(names), {"position": [x] * len(names), "effort": [3 * x] * len(names)})
        for t, x in zip(stamps, values.tolist(), strict=True)
    ]


def read(*publishers, hold=None):
    states = sorted((state for each in publishers for state in each), key=lambda state: state.stamp)
    reading = Reading("none", hold=hold_of(hold), measured=True)
    with TrajectoryReader(LogTable("log", states), signals(robodyn.load(ROBOT)), (), reading) as reader:
        return join(list(reader.blocks()))


def place(name):
    return robodyn.load(ROBOT).rates.index(name)


MAIN = NANO + STEP * np.arange(200)


def test_equal_stamps_give_the_numbers_of_the_messages():
    """To the bit, and no joint that the log has is held."""
    block = read(publisher(["shoulder"], MAIN), publisher(["elbow"], MAIN), hold="rest")
    assert not block.held
    for name in ("shoulder", "elbow"):
        np.testing.assert_array_equal(block.q[:, place(name)], angle(MAIN))
        np.testing.assert_array_equal(block.extra[f"tau_{name}"], 3 * angle(MAIN))
    assert "messages of another publisher about 'elbow' are interpolated onto the stamps of the others" in block.notes


def test_stamps_between_are_interpolated():
    """A chord is off a sine by h^2 / 8 max|q''| at most; the stretch is that of both publishers."""
    other = NANO + 3_000_000 + STEP * np.arange(10, 150)
    block = read(publisher(["shoulder"], MAIN), publisher(["elbow"], other))
    stamps = MAIN[(other[0] <= MAIN) & (other[-1] >= MAIN)]
    np.testing.assert_array_equal(block.q[:, place("shoulder")], angle(stamps))
    bound = (1e-9 * STEP) ** 2 / 8 * 4.0
    assert np.abs(block.q[:, place("elbow")] - angle(stamps)).max() < bound
    assert f"{200 - len(stamps)} messages left out, not between two about 'elbow'" in block.notes


def test_in_gaps_of_a_publisher_there_are_no_rows():
    block = read(publisher(["shoulder"], MAIN), publisher(["elbow"], np.delete(MAIN, np.s_[50:60])))
    np.testing.assert_array_equal(block.q[:, place("elbow")], angle(np.delete(MAIN, np.s_[50:60])))


def test_between_turns_the_nearer_message_counts():
    """Of an angle that jumps from pi to -pi nothing stands between."""
    other = MAIN[:-1] + 3_000_000

    def turning(stamps):
        return np.where(np.arange(len(stamps)) % 2, 3.1, -3.1)

    block = read(publisher(["shoulder"], MAIN), publisher(["elbow"], other, turning))
    np.testing.assert_array_equal(block.q[:, place("elbow")], turning(other)[1:])


def test_joints_that_the_robot_has_not_cost_no_rows():
    block = read(publisher(["shoulder", "elbow"], MAIN), publisher(["finger"], MAIN[:3] + 1))
    assert len(block) == 200


def test_publishers_of_different_times_are_refused():
    with pytest.raises(TrajectoryError) as caught:
        read(publisher(["shoulder"], MAIN), publisher(["elbow"], MAIN[:50] + 10 * NANO), hold="rest")
    what = "log: messages about 'elbow' and those about the other joints are of different times (record them together)"
    assert str(caught.value) == what
