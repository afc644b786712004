"""Errors of torques against many digits, and what effects are worth."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.errors import InputError
from robodyn.measure.accuracy.torques import file_accuracy
from robodyn.robot.load import load
from robodyn.scene.scene import DEFAULT
from robodyn.trajectory.read import read_motion

SCARA, MOTION = ROBOTS / "scara.urdf", str(ROBOTS / "scara_pick_and_place.csv")

pytest.importorskip("mpmath")


def test_scara() -> None:
    model = load(SCARA)
    found = file_accuracy(model, DEFAULT, MOTION)
    executors, derivatives, rates = found.ladders
    errors = {rung.name: rung.error for rung in executors.rungs}
    assert errors["numpy float64"] <= 1e-14
    assert 1e-12 < errors["numpy float32"] <= 1e-6
    assert errors["mpmath, 20 digits"] <= 1e-19
    assert errors["double-double"] <= 1e-29
    assert [rung.name.partition(",")[0] for rung in rates.rungs] == [
        *("every sample", "every 2nd", "every 4th", "every 8th")
    ]
    assert rates.rungs[0].error == 0.0 < rates.rungs[1].error
    assert {rung.operations for rung in executors.rungs} == {executors.rungs[0].operations}
    assert [rung.name for rung in derivatives.rungs] == ["auto", "spline", "savgol", "central"]
    with read_motion(MOTION, model) as reader:
        block = next(iter(reader.blocks()))
    tau = inverse_dynamics(model, block.q, block.qd, block.qdd)
    still = inverse_dynamics(model, block.q, block.qd, block.qdd, scene=replace(DEFAULT, gravity=(0.0, 0.0, 0.0)))
    gravity = found.effects[0]
    assert (gravity.name, gravity.unit, gravity.joint) == ("gravity", "N", "quill")
    assert gravity.torque == pytest.approx(np.abs(tau - still).max(), rel=1e-12)
    assert all(effect.saved >= 0 for effect in found.effects)


@pytest.mark.slow
def test_derived_accelerations_are_measured_on_a_motion_like_the_given_one() -> None:
    """With noise, methods that do not smooth are bad by a lot."""
    found = file_accuracy(load(ROBOTS / "puma.urdf"), DEFAULT, str(ROBOTS / "puma_encoder.csv"))
    derivatives = found.ladders[1]
    assert derivatives.reference == "a smooth motion like the given one, with noise of 1.5e-05 as in it"
    errors = {rung.name: rung.error for rung in derivatives.rungs}
    assert errors["auto"] < 1e-2 > errors["savgol"]
    assert errors["central"] > 1.0


@pytest.fixture
def spinning(tmp_path: Path):
    """A table of nine rows at these speeds of two joints."""

    def write(speed: float) -> str:
        path = tmp_path / "fast.csv"
        names = [f"{kind}_{joint}" for kind in ("q", "qd", "qdd") for joint in ("shoulder", "elbow", "quill")]
        rows = [f"{k / 100},0.1,0.2,0.3,{speed},{speed},0,0,0,0\n" for k in range(9)]
        path.write_text(f"time,{','.join(names)}\n{''.join(rows)}")
        return str(path)

    return write


def test_what_single_precision_cannot_hold_is_left_out(spinning) -> None:
    found = file_accuracy(load(SCARA), DEFAULT, spinning(1e30))
    assert "numpy float32: the torques overflow" in found.notes
    assert "numpy float64" in [rung.name for rung in found.ladders[0].rungs]
    with pytest.raises(InputError, match="overflow"):
        file_accuracy(load(SCARA), DEFAULT, spinning(1e200))
