"""`robodyn torques --example`: a motion to begin with, for any robot, which exceeds no limit that a motion can keep."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import run, write_arm
from helpers.example_robots import LARGE_ONES, PATHS, path_of
from helpers.oracles import robot
from helpers.other_robots import other_paths
from helpers.small_robots import built, joint, link, urdf
from scipy.interpolate import make_interp_spline

from robodyn.loads.example_motion import example_motion, overloaded
from robodyn.loads.torques import torques
from robodyn.robot.load import load
from robodyn.scene.scene import Friction, Payload, Scene, Spring
from robodyn.trajectory.read import motion

LIFT = (link("l0"), link("l1", 20.0), joint("lift", "l0", "l1", "prismatic"))


def split(model, columns):
    return columns[:, : model.nq], columns[:, model.nq : model.nq + model.n], columns[:, model.nq + model.n :]


@pytest.mark.parametrize("name", ["scara", "satellite", "gripper"])
def test_within_limits_and_consistent(name: str) -> None:
    within(robot(name))


@pytest.mark.parametrize(
    "name", ["panda", *(pytest.param(name, marks=pytest.mark.slow) for name in ("baxter", "talos_left_arm"))]
)
def test_real_robots(name: str) -> None:
    """Baxter cannot hold its arms level; the gripper of TALOS has more friction than effort, and stands still."""
    within(load(path_of(name)))


@pytest.mark.slow
def test_robots_keep_limits_that_standing_still_keeps() -> None:
    """Twelve of all kinds; the suspensions of tiago_dual carry 116 N of 100 in any pose."""
    every = [path for path in [*PATHS, *other_paths()] if path.stem not in LARGE_ONES]
    for path in [path_of("tiago_dual"), *every[:: len(every) // 11]]:
        model = load(path)
        if model.n:
            _, time, columns = example_motion(model)
            beyond = {excess.joint for excess in torques(model, motion(model, time, *split(model, columns))).exceeded}
            expected = {"suspension_right_joint", "suspension_left_joint"} if path.stem == "tiago_dual" else set()
            assert beyond == expected, path
            said = " ".join(overloaded(model, Scene(), columns))
            assert all(f'"{name}"' in said for name in beyond)


def within(model) -> None:
    names, time, columns = example_motion(model)
    q, qd, qdd = split(model, columns)
    assert len(names) == columns.shape[1]
    assert not qd[[0, -1]].round(12).any()
    result = torques(model, motion(model, time, q, qd, qdd))
    assert result.checks.energy_balance.consistent
    assert not result.exceeded
    said = " ".join(overloaded(model, Scene(), columns))
    assert all(joint.max_speed or f'"{joint.name}" stands still' in said for joint in result.joints)
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


def test_a_load_that_is_too_heavy_is_said(tmp_path: Path) -> None:
    """20 kg weigh 196 N wherever they stand, and swing by 1 N more."""
    (tmp_path / "lift.urdf").write_bytes(urdf(*LIFT).replace(b'effort="1000"', b'effort="150"'))
    outcome = run("torques", str(tmp_path / "lift.urdf"), str(tmp_path / "motion.csv"), "--example")
    assert outcome.status == 0
    assert outcome.err.startswith('warning: the example exceeds the effort limit of "lift", 197 of')
    assert outcome.err.endswith(" of 150 N: so does standing still\n")


def test_joints_that_cannot_move_stand_still() -> None:
    model = built(*LIFT)
    scene = Scene(friction={"lift": Friction(forward=950.0, backward=-950.0)})
    _, _, columns = example_motion(model, scene)
    assert not columns[:, 1:].any()
    said = '"lift" stands still in the example: moving takes more than its limit of 1000 N'
    assert overloaded(model, scene, columns) == [said]


@pytest.mark.parametrize(
    "scene",
    [Scene(payloads=(Payload("fore", 30.0),)), Scene(spring={"shoulder": Spring(60.0, 2.0)}), Scene()],
    ids=["payload", "spring", "none"],
)
def test_the_scene_counts(scene: Scene, tmp_path: Path) -> None:
    """The arm's 50 N m hold 30 kg where the arm hangs or stands, and its spring near where that rests."""
    write_arm(tmp_path)
    model = load(tmp_path / "arm.urdf")
    _, time, columns = example_motion(model, scene)
    result = torques(model, motion(model, time, *split(model, columns)), scene)
    assert not result.exceeded
    assert all(joint.max_speed for joint in result.joints)
