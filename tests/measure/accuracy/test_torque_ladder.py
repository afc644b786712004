"""Errors of torques against many digits, and what effects are worth."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.errors import InputError
from robodyn.measure.accuracy.torques import file_accuracy, like, noisy, torque_accuracy
from robodyn.robot.load import load
from robodyn.scene.scene import DEFAULT
from robodyn.trajectory.motion import Derivation, JointDerivation
from robodyn.trajectory.read import motion, read_motion

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
        *("every sample", "every 2nd", "every 4th", "every 8th"),
    ]
    assert rates.rungs[0].error == 0.0 < rates.rungs[1].error
    assert {rung.operations for rung in executors.rungs} == {float(_operations(found))}
    assert [rung.name for rung in derivatives.rungs] == ["auto", "spline", "savgol", "central"]
    with read_motion(MOTION, model) as reader:
        block = next(iter(reader.blocks()))
    tau = inverse_dynamics(model, block.q, block.qd, block.qdd)
    still = inverse_dynamics(model, block.q, block.qd, block.qdd, scene=_weightless())
    gravity = found.effects[0]
    assert (gravity.name, gravity.unit, gravity.joint) == ("gravity", "N", "quill")
    assert gravity.torque == pytest.approx(np.abs(tau - still).max(), rel=1e-12)
    assert all(effect.saved >= 0 for effect in found.effects)


def _operations(found) -> float:
    return found.ladders[0].rungs[0].operations


def _weightless():
    return replace(DEFAULT, gravity=(0.0, 0.0, 0.0))


def test_derived_accelerations_are_measured_on_a_motion_like_the_given_one() -> None:
    """With noise, methods that do not smooth are bad by a lot; the motion like it has the torques of the given one."""
    model = load(ROBOTS / "puma.urdf")
    found = file_accuracy(model, DEFAULT, str(ROBOTS / "puma_encoder.csv"))
    derivatives = found.ladders[1]
    assert derivatives.reference == "a smooth motion like the given one, with noise of 1.5e-05 as in it"
    errors = {rung.name: rung.error for rung in derivatives.rungs}
    assert errors["auto"] < 1e-2 > errors["savgol"]
    assert errors["central"] > 1.0
    with read_motion(str(ROBOTS / "puma_encoder.csv"), model) as reader:
        block = next(iter(reader.blocks()))
    twin = like(model, block)
    middle = [0.5 * (x[1:] + x[:-1]) for x in (block.time, block.q, block.qdd)]
    assert np.abs(twin.time - middle[0]).max() < 1e-12
    assert np.abs((twin.q - middle[1]).mean(axis=0)).max() < 1e-5
    assert np.abs(twin.q - middle[1]).max() < 5e-3
    off = np.abs(twin.qdd - middle[2])  # windows, and with them estimates, change from sample to sample
    assert off.max() <= 5e-3 * np.abs(block.qdd).max()
    assert off.mean() <= 1e-4 * np.abs(block.qdd).max()
    step = (twin.q[2:] - 2 * twin.q[1:-1] + twin.q[:-2]) / 1e-6
    assert np.abs(step - twin.qdd[1:-1]).max() < 5e-3 * np.abs(twin.qdd).max()


def test_noise_is_added_as_it_was_found() -> None:
    model = load(SCARA)
    joint = JointDerivation("elbow", "", "", "q", 0.0, 1e-3, 0.0)
    off, said = noisy(model, np.zeros((4000, 3)), Derivation((joint,)))
    assert np.std(off, axis=0) == pytest.approx([0, 1e-3, 0], rel=0.1)
    assert said == "a smooth motion like the given one, with noise of 1.0e-03 as in it"
    grid, _ = noisy(model, np.full((9, 3), 0.123), Derivation((replace(joint, quantum=0.05),)))
    assert np.abs(grid[:, 1] - [0.1]).max() < 1e-12
    assert (grid[:, [0, 2]] == 0.123).all()


def test_a_floating_joint_without_accelerations_is_not_measured() -> None:
    model = load(ROBOTS / "satellite.urdf", moving_base=True)
    time = np.arange(200) / 100
    q = np.zeros((200, model.nq))
    q[:, 6] = 1.0
    q[:, 7:] = np.sin(time)[:, None]
    found = torque_accuracy(model, motion(model, time, q), replace(DEFAULT, moving_base=True))
    assert [ladder.title for ladder in found.ladders] == ["torques", "sample rate"]
    assert found.notes[0].startswith("derivatives: a floating joint without accelerations")


def test_without_mpmath_there_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "mpmath", None)
    with pytest.raises(InputError, match="mpmath"):
        file_accuracy(load(SCARA), DEFAULT, MOTION)


def test_what_single_precision_cannot_hold_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "fast.csv"
    path.write_text("time,q_shoulder,q_elbow,q_quill,qd_shoulder,qd_elbow,qd_quill,qdd_shoulder,qdd_elbow,qdd_quill\n")
    with path.open("a") as file:
        file.writelines(f"{k / 100},0.1,0.2,0.3,1e30,1e30,0,0,0,0\n" for k in range(9))
    found = file_accuracy(load(SCARA), DEFAULT, str(path))
    assert "numpy float32: the torques overflow" in found.notes
    assert "numpy float64" in [rung.name for rung in found.ladders[0].rungs]


def test_torques_that_overflow(tmp_path: Path) -> None:
    path = tmp_path / "wild.csv"
    path.write_text("time,q_shoulder,q_elbow,q_quill,qd_shoulder,qd_elbow,qd_quill,qdd_shoulder,qdd_elbow,qdd_quill\n")
    with path.open("a") as file:
        file.writelines(f"{k / 100},0.1,0.2,0.3,1e200,1e200,0,0,0,0\n" for k in range(9))
    with pytest.raises(InputError, match="overflow"):
        file_accuracy(load(SCARA), DEFAULT, str(path))
