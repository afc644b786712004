"""Joints without columns that are held still: where, which, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from robodyn.errors import TrajectoryError
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.reader import TrajectoryReader
from robodyn.trajectory.readers.table import ArrayTable
from robodyn.trajectory.reading import HoldGiven, Reading, hold_of

ARM = Signals(
    (Signal("wrist", "angle", -2.0, 2.0), Signal("elbow", "angle", 0.5, 2.0), Signal("lift", "length", -0.5, -0.1)),
    dependent=("finger",),
)
FREE = Signals((Signal("base", "floating"), *ARM.joints))
TIME = np.arange(20) / 100


def read(signals: Signals, hold: HoldGiven | None, *columns: str, **reading: object) -> Trajectory:
    table = ArrayTable(None, {"time": TIME, **{name: np.sin(TIME) for name in columns}})
    reader = TrajectoryReader(table, signals, reading=Reading(hold=hold_of(hold), **reading))  # type: ignore[arg-type]
    (block,) = reader.blocks()
    return block


@pytest.mark.parametrize(
    ("hold", "places"),
    [
        ("rest", (0.5, -0.1)),
        ("rest,elbow=0.7", (0.7, -0.1)),
        ("elbow=0.7, lift=rest", (0.7, -0.1)),
        (0.25, (0.25, 0.25)),
        ("-0.25", (-0.25, -0.25)),
        ({"elbow": "rest", "lift": -1e-3}, (0.5, -0.001)),
    ],
)
def test_held_where_it_is_said(hold: HoldGiven, places: tuple[float, float]) -> None:
    """At rest is nearest to zero within the limits; velocities and accelerations are zero, not derived."""
    found = read(ARM, hold, "wrist")
    assert (found.q[:, 1:] == places).all()
    assert not found.qd[:, 1:].any()
    assert not found.qdd[:, 1:].any()
    assert found.held == dict(zip(("elbow", "lift"), places, strict=True))
    assert found.derivation is not None
    assert [joint.name for joint in found.derivation.joints] == ["wrist"]


def test_held_angles_are_in_the_unit_of_angles() -> None:
    found = read(ARM, "elbow=90,lift=-0.2", "wrist", angle_unit="deg")
    assert found.held == {"elbow": pytest.approx(math.pi / 2, rel=1e-15), "lift": -0.2}


@pytest.mark.parametrize(
    ("hold", "columns", "message"),
    [
        (None, ("wrist",), "no position of joint 'elbow', 'lift' (--hold rest keeps joints without columns still"),
        ("elbow=1", ("wrist",), "no position of joint 'lift'"),
        ("elbow=1,lift=0", ("wrist", "elbow"), "joint 'elbow' is to be held, and column 'elbow' moves it"),
        ("rest", ("wrist", "qd_elbow"), "joint 'elbow' is to be held, and column 'qd_elbow' moves it"),
        ("rest,elbw=1", ("wrist",), "no joint 'elbw' to hold (did you mean 'elbow'?)"),
        ("rest,finger=1", ("wrist",), "no joint 'finger' to hold (it follows another)"),
        (
            "resting",
            ("wrist",),
            "'resting' is no place to hold a joint (rest, a number, or joints as in rest,elbow=0.3)",
        ),
        ("nan", ("wrist",), "'nan' is no place"),
        ("1_0", ("wrist",), "'1_0' is no place"),
        ("elbow=", ("wrist",), "'' is no place"),
    ],
)
def test_what_cannot_be_held(hold: HoldGiven | None, columns: tuple[str, ...], message: str) -> None:
    with pytest.raises(TrajectoryError) as caught:
        read(ARM, hold, *columns)
    assert message in str(caught.value)


def test_a_floating_joint_is_held_at_its_place() -> None:
    found = read(FREE, "rest,base_z=0.8", "wrist")
    assert (found.q[:, :7] == (0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 1.0)).all()
    assert not found.qd[:, :6].any()
    assert found.notes == ()
    assert found.held["base_z"] == 0.8


def test_the_rest_of_a_floating_joint_with_columns_is_as_before() -> None:
    found = read(FREE, "rest,base_z=0.8", "wrist", "base_x")
    assert (found.q[:, 1:3] == (0.0, 0.8)).all()
    assert "base: position y is not given and taken as 0" in found.notes


def test_one_number_does_not_place_a_floating_joint() -> None:
    with pytest.raises(TrajectoryError) as caught:
        read(FREE, "rest,base=1", "wrist")
    assert "joint 'base' moves freely, one number does not place it (give base_x=..., base_y=" in str(caught.value)
