"""`robodyn torques --example`: a motion to begin with, for any robot, which exceeds no limit of place or speed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from command_line import run, write_arm
from example_robots import path_of
from oracles import robot
from scipy.interpolate import make_interp_spline

from robodyn.assemble import load
from robodyn.example_motion import example_motion
from robodyn.loads import torques
from robodyn.motion_input import motion


def split(model, columns):
    return columns[:, : model.nq], columns[:, model.nq : model.nq + model.n], columns[:, model.nq + model.n :]


@pytest.mark.parametrize("name", ["puma560", "scara", "cylindrical", "satellite", "two_link_spatial", "gripper"])
def test_within_limits_and_consistent(name: str) -> None:
    within(robot(name))


@pytest.mark.parametrize("name", ["ur5_robot", "panda", "romeo_small"])
def test_real_robots(name: str) -> None:
    within(load(path_of(name)))


def within(model) -> None:
    names, time, columns = example_motion(model)
    q, qd, qdd = split(model, columns)
    assert len(names) == columns.shape[1]
    assert not qd[[0, -1]].round(12).any()
    result = torques(model, motion(model, time, q, qd, qdd))
    assert result.checks.energy_balance.consistent
    assert not [excess for excess in result.exceeded if excess.quantity != "effort"]
    free = [k for k, joint in enumerate(result.joints) if joint.velocity_limit != 0]
    assert all(result.joints[k].max_speed for k in free)
    rates = make_interp_spline(time, qd, k=7).derivative()(time)
    np.testing.assert_allclose(rates, qdd, rtol=0, atol=1e-10 * np.abs(qdd).max())


def test_command(tmp_path: Path) -> None:
    write_arm(tmp_path)
    file, call = tmp_path / "motion.csv", ("torques", str(tmp_path / "arm.urdf"), str(tmp_path / "motion.csv"))
    outcome = run(*call, "--example")
    assert outcome.status == 0
    assert f"written: {file}, an example motion" in outcome.out
    assert "No limit is exceeded" in outcome.out
    text = file.read_text()
    assert text.startswith("time,q_shoulder,q_elbow,qd_shoulder,qd_elbow,qdd_shoulder,qdd_elbow\n")
    assert run(*call).status == 0
    again = run(*call, "--example")
    assert (again.status, again.out, file.read_text()) == (2, "", text)
    assert "this one is there already (leave --example out" in again.err
