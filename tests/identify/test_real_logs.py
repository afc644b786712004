"""Logs of real robots, a Staubli TX40 with a coupled wrist and a UR10; and logs as users bring them: short, of clean
torques, of joints that move together."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import polars
import polars.selectors
import pytest
from helpers.command_line import ROBOTS, run
from helpers.example_robots import path_of
from helpers.identified_logs import waves, write_log

import robodyn
from robodyn import Friction, Scene
from robodyn.identification.result import Errors, Identified

DATA = Path(__file__).parents[1] / "data" / "tx40_log"
TX40, LOG = str(DATA / "tx40.urdf"), str(DATA / "log.parquet")
URDF = str(ROBOTS / "scara.urdf")
JOINTS = ("shoulder", "elbow", "quill")
FRICTION = {
    name: Friction(viscous=0.3, forward=dry, backward=-dry) for name, dry in zip(JOINTS, (5.0, 2.0, 1.5), strict=True)
}


def write(path, *, together=False):
    """Write a log of a SCARA with friction that its description does not have, 200 rows/s, and noise of 0.1 %.

    `together`, both arms turn alike.
    """
    model, time, rng = robodyn.load(URDF), np.arange(1200) / 200.0, np.random.default_rng(0)
    states = waves(rng, time, 3, np.array([2.0, 2.0, 0.1]))
    for each in states if together else ():
        each[:, 1] = each[:, 0]
    tau = robodyn.inverse_dynamics(model, *states, scene=Scene(friction=FRICTION))
    write_log(path, model, time, states[0], tau + 1e-3 * tau.std(axis=0) * rng.normal(size=tau.shape))
    return str(path)


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return write(tmp_path_factory.mktemp("log") / "log.csv")


def identified(*arguments):
    return json.loads(run("identify", *arguments, "--format", "json").out)


def test_friction_without_breakaway(log):
    found = identified(URDF, log)
    assert found["consistent"]
    assert not any("'base'" in each for each in found["warnings"])
    assert found["held_out"]["relative_error"] < 5e-3
    for motor in found["friction"]:
        dry = FRICTION[motor["name"]].forward
        assert motor["coulomb"] == pytest.approx(dry, rel=0.05)
        if motor["stribeck"] is not None:
            assert motor["stribeck_velocity"] > 5.0 * found["slip_speed"]
            assert motor["stribeck"] < 1.6 * dry


@pytest.mark.parametrize(("new", "old", "better"), [(0.3, 0.5, True), (0.6, 0.5, False), (1.2, 1.8, False)])
def test_what_explains_less_than_nothing_is_not_better(new, old, better):
    judged = Errors(new, {}), Errors(old, {})
    assert Identified.better.fget(SimpleNamespace(judged=judged)) is better


def test_joints_that_move_together_show_no_motor_of_their_difference(tmp_path):
    assert not identified(URDF, write(tmp_path / "log.csv", together=True))["coupled"]


def test_a_short_log_is_compared_by_default(log):
    assert "compared below 10 Hz over 4.4" in run("torques", URDF, log, "--measured").out


@pytest.mark.parametrize(
    ("factors", "said"),
    [({"time": 1e3}, "are the stamps milliseconds?"), ({"q_": np.degrees(1.0)}, "are these degrees?")],
)
@pytest.mark.slow
def test_units_that_are_doubtful_are_not_written(factors, said, tmp_path):
    log, out = tx40(tmp_path, factors), tmp_path / "out.urdf"
    outcome = run("identify", TX40, log, "--out", str(out))
    assert outcome.status == 2
    assert said in outcome.err
    assert not out.exists()


@pytest.mark.slow
def test_joints_that_are_held_are_told_once(tmp_path):
    outcome = run("identify", TX40, tx40(tmp_path, {}, leave_out="joint_6"), "--cutoff", "40")
    assert [line.rpartition(": ")[2] for line in outcome.out.splitlines() if "joint_6" in line] == [
        "joint_6 is held at 0"
    ]


def tx40(folder, factors, leave_out="nothing"):
    """The real log with columns in other units."""
    table = polars.read_parquet(LOG)
    for begin, factor in factors.items():
        table = table.with_columns(polars.selectors.starts_with(begin) * factor)
    path = folder / "log.parquet"
    table.drop(polars.selectors.ends_with(leave_out)).write_parquet(path)
    return str(path)


HALF = ("--split", "0.5", "--cutoff", "40")


@pytest.fixture(scope="module")
def half(tmp_path_factory):
    """What the first half of the log tells, and the files."""
    folder = tmp_path_factory.mktemp("tx40")
    urdf, scene = str(folder / "calibrated.urdf"), str(folder / "friction.toml")
    return identified(TX40, LOG, *HALF, "--out", urdf, "--scene-out", scene), urdf, scene


@pytest.mark.slow
def test_tx40_second_half(half):
    """Plain least squares have 12.83 % on the second half; every body can exist; motor 6 is found."""
    found, out, _ = half
    assert found["held_out"]["relative_error"] < 0.12
    assert found["train"]["relative_error"] < 0.083
    assert found["original"]["relative_error"] > 0.7
    assert found["consistent"]
    assert found["better"]
    assert [each["name"] for each in found["coupled"]] == ["joint_5+joint_6"]
    friction = {each["name"]: each for each in found["friction"]}
    published = {"joint_1": 8.05, "joint_2": 5.53, "joint_3": 1.97, "joint_5+joint_6": 0.616}
    for name, viscous in published.items():
        assert friction[name]["viscous"] == pytest.approx(viscous, rel=0.3)
    model = robodyn.load(out)
    for body in model.bodies[1:]:
        assert body.inertia.m > 0.0
        moments = np.linalg.eigvalsh(body.inertia.about_centre)
        assert moments[0] > 0.0
        assert moments[0] + moments[1] >= moments[2]


@pytest.mark.slow
def test_a_joint_that_is_held_out_much_worse_is_told():
    """What the first 70 % of the log tell of joint 5 is not what the last 30 % need."""
    said = [line.startswith("joint_5: held-out torques are off by") for line in identified(TX40, LOG)["warnings"]]
    assert said.count(True) == 1


@pytest.mark.slow
def test_ur10_last_forty_percent():
    """Plain least squares have 7.79 %; the stock description, without friction, 45 %."""
    urdf = path_of("ur10_robot")
    found = identified(str(urdf), str(DATA.parent / "ur10_log" / "log.parquet"), "--split", "0.6", "--cutoff", "8")
    assert found["held_out"]["relative_error"] < 0.075
    assert found["original"]["relative_error"] > 0.4
    assert found["consistent"]


@pytest.mark.slow
def test_tx40_files_reproduce_the_fit(half):
    """The description and the scene that are written make the torques of the fit, and a fit can begin with them."""
    found, urdf, scene = half
    (motor,) = robodyn.load_scene(scene).coupled
    assert motor.joints == {"joint_5": 1.0, "joint_6": 1.0}
    again = identified(urdf, LOG, *HALF, "--scene", scene)
    for part in ("train", "held_out"):
        errors = again["original"][part]["relative_error"], found[part]["relative_error"]
        assert errors[0] == pytest.approx(errors[1], rel=1e-6)
    bare = identified(urdf, LOG, *HALF)["original"]["held_out"]["relative_error"]
    said = re.search(r"without it about (\d+) %", Path(urdf).read_text())
    assert said is not None
    assert float(said[1]) / 100.0 == pytest.approx(bare, abs=0.006)
    assert again["train"]["relative_error"] < 1.02 * found["train"]["relative_error"]
