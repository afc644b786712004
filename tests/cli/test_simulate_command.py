"""`robodyn simulate`: its report, its table, which `torques` reads back, and calls that are wrong."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS, refused, run, shown, write_arm

SWING = (str(ROBOTS / "two_link_planar.urdf"), "--scene", str(ROBOTS / "two_link_planar_swing_down.toml"))


def rows(path: Path) -> tuple[list[str], np.ndarray]:
    with open(path, encoding="utf-8") as lines:
        return next(lines).strip().split(","), np.loadtxt(lines, delimiter=",")


def test_report() -> None:
    text = shown("simulate", *SWING, "--duration", "0.5")
    assert text.startswith(
        "two_link_planar: 0.5 s, gravity (0, 0, -9.81) m/s^2\neffects on: gravity, inertia, coriolis, "
    )
    assert "viscous friction, coulomb friction; no contact\n" in text
    assert "method: rk4 of order 4 (the classical Runge-Kutta method), 500 steps of 0.001 s, 2000 evaluations" in text
    assert "note: Coulomb friction is regularised, f qd / sqrt(qd^2 + 0.01^2): up to 40 N m s/rad near rest\n" in text
    assert "momentum" not in text


def test_torques_of_the_simulated_motion_are_those_applied(tmp_path: Path) -> None:
    motion, loads = tmp_path / "motion.csv", tmp_path / "tau.csv"
    text = shown("simulate", *SWING, "--duration", "0.5", "--out", str(motion))
    assert text.endswith(f"\nwritten: {motion}, 501 rows of time and 8 columns\n")
    again = run("torques", SWING[0], str(motion), *SWING[1:], "--out", str(loads))
    assert again.status == 0
    assert "columns not used: 'tau_shoulder', 'tau_elbow'" in again.out
    names, table = rows(motion)
    assert names == [
        "time",
        *(f"{kind}_{joint}" for kind in ("q", "qd", "qdd", "tau") for joint in ("shoulder", "elbow")),
    ]
    _, found = rows(loads)
    assert np.abs(found[:, 1:] - table[:, -2:]).max() <= 1e-13 * np.abs(table[:, -2:]).max()


def test_json() -> None:
    document = json.loads(shown("simulate", *SWING, "--duration", "0.1", "--format", "json", "--method", "gauss4"))
    assert document["method"] == {"name": "gauss4", "order": 4, "step": 0.001, "rtol": None}
    assert document["ended"] is document["momentum_drift"] is None
    assert 2 * 2 * 100 <= document["evaluations"] <= 2 * 12 * 100
    assert set(document["final"]["q"]) == {"shoulder", "elbow"}


WRONG = [
    (("--method", "rk5"), "", "there is no method 'rk5' (did you mean 'rk4'?)"),
    (("--step", "0"), "", "step is 0 (give a positive number)"),
    (("--duration", "nan"), "", "duration is nan (give a positive number)"),
    (("--rtol", "-1"), "", "rtol is -1 (give a positive number)"),
    (("--duration", "1e30"), "", "1e+33 steps are too many (give a longer --step)"),
    (("--method", "dop853", "--step", "1"), "", "dop853 chooses its own steps (give --rtol instead of --step)"),
    (("--method", "rk4", "--rtol", "1e-9"), "", "rk4 has steps of a fixed length (give --step instead of --rtol)"),
    ((), "[drive]\nelbw = {}", "scene.toml: [drive]: the robot has no joint 'elbw' that moves (did you mean 'elbow'?)"),
    ((), "[initial]\nq = { wrist = 1 }", "scene.toml: [initial] q: the robot has no coordinate 'wrist'"),
    ((), "[initial]\nq = { elbow = 4 }", '"elbow" begins at 4, beyond its limit of 3 (begin within the limits, or'),
    ((), "[contact]\n", 'scene.toml:1: the scene: "contact" is not a list of tables (write [[contact]] above each)'),
    (
        *((), '[[wrench]]\nlink = "fore"\nforce = ["fx", 0, 0]'),
        "the scene names 'fx', columns of a table (give the table: --traj FILE)",
    ),
    (("--traj", "no.csv"), "", "scene.toml: no column of no.csv is named, so that it drives nothing (e.g. drive.elbow"),
    (("--traj", "no.csv"), '[drive]\nelbow = { torque = "ff" }', "no.csv: cannot be read: no such file or directory"),
    (("--method", "verlet"), "", "verlet does not apply: accelerations depend on speeds (coriolis)"),
    ((), "[drive]\nelbow = { kp = -1e8 }\n[initial]\nq = { elbow = 1 }", "the motion cannot be followed at "),
]


@pytest.mark.parametrize(("more", "scene", "line"), WRONG)
def test_wrong_calls(
    more: tuple[str, ...], scene: str, line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_arm(tmp_path)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(scene)
    refused(run("simulate", "arm.urdf", "--scene", "scene.toml", *more), line)


def test_a_stiff_drive_needs_a_stiff_method(tmp_path: Path) -> None:
    write_arm(tmp_path)
    (tmp_path / "stiff.toml").write_text("[drive]\nelbow = { kp = 1e4, kd = 1e4 }\nshoulder = { kp = 1e4, kd = 1e4 }\n")
    call = ("simulate", str(tmp_path / "arm.urdf"), "--scene", str(tmp_path / "stiff.toml"), "--duration", "1")
    outcome = run(*call, "--method", "gauss4", "--step", "1e-3")
    refused(outcome, "the motion cannot be followed at 0 s: a number overflows (give --step ")
    assert outcome.err.endswith(", or --method radau)\n")
    text = shown("simulate", *call[1:])
    assert "method: radau of order 5" in text
    assert 'note: the drive\'s kd of "elbow" settles at ' in text
    assert "/s: radau follows it\n" in text


def test_drives_follow_a_table(tmp_path: Path) -> None:
    """What `simulate` writes, another simulation follows: torques fed forward, references with their slopes."""
    motion, again = tmp_path / "motion.csv", tmp_path / "again.csv"
    shown("simulate", *SWING, "--duration", "1", "--out", str(motion))
    joints = ("shoulder", "elbow")
    (tmp_path / "follow.toml").write_text(
        "slip_speed = 0.01\nfriction.shoulder = { viscous = 3.0, coulomb = 0.4 }\n"
        + "".join(f'initial.{kind}.{name} = "{kind}_{name}"\n' for kind in ("q", "qd") for name in joints)
        + "".join(
            f'drive.{name} = {{ torque = "tau_{name}", kp = 50, kd = 5, reference = "q_{name}" }}\n' for name in joints
        )
    )
    follow = (SWING[0], "--scene", str(tmp_path / "follow.toml"), "--traj", str(motion))
    text = shown("simulate", *follow, "--out", str(again))
    assert (
        f"note: table {motion}: 1001 rows over 1 s; references are cubic splines, with their slopes for speeds; "
        in text
    )
    assert "torques and wrenches between rows are straight\n" in text
    (names, first), (_, second) = rows(motion), rows(again)
    places = [names.index(f"q_{name}") for name in joints]
    assert np.abs(first[:, places] - second[:, places]).max() <= 5e-6


@pytest.mark.slow
def test_json_of_friction_that_holds_and_springs_at_limits() -> None:
    scene = str(ROBOTS / "puma560_power_cut.toml")
    document = json.loads(
        shown("simulate", str(ROBOTS / "puma560.urdf"), "--scene", scene, "--duration", "3", "--format", "json")
    )
    wrist = document["held"][4]
    assert (wrist["joint"], wrist["time"]) == ("wrist_pitch", 3.0)
    assert 0 < wrist["creep"] < 1e-3
    assert document["limit_spring"]["joint"] == "shoulder"
    assert abs(document["limit_spring"]["depth"] - 0.02697) <= 1e-5
