"""`robodyn fbd`: states, its text, its JSON and its drawings."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run

import robodyn
from robodyn.programs.vectors import product

SCARA = str(ROBOTS / "scara.urdf")
PUMA = (str(ROBOTS / "puma.urdf"), "--scene", str(ROBOTS / "puma_polish.toml"))
POLISH = str(ROBOTS / "puma_polish.csv")


def test_text() -> None:
    outcome = run("fbd", SCARA, "--at", "0.3,-0.5,0.05", "--qd", "quill=0.1", "--qdd", "elbow=2")
    assert (outcome.status, outcome.err) == (0, "")
    assert "scara: 4 bodies, as given, moving, accelerating, gravity (0, 0, -9.81) m/s^2" in outcome.out
    assert "4 bodies x 6 equations = 24 = 21 reactions + 3 along the degrees of freedom" in outcome.out
    sums = [line.split() for line in outcome.out.splitlines() if line.startswith("sum")]
    assert sums == [["sum", *"000000"]] * 4
    assert "reaction, elbow" in outcome.out


def test_json_is_that_of_the_library_to_the_last_bit() -> None:
    outcome = run("fbd", SCARA, "--at", "elbow=-0.5", "--qd", "1,2,0.1", "--format", "json")
    found = json.loads(outcome.out)
    expected = robodyn.free_bodies(robodyn.load(SCARA), [0, -0.5, 0], [1, 2, 0.1])
    assert found["q"] == {"shoulder": 0.0, "elbow": -0.5, "quill": 0.0}
    assert found["tau"] == expected.tau
    for body, other in zip(found["bodies"], expected.bodies, strict=True):
        R = np.array(body["frame"]["rotation"])
        for action, own in zip(body["actions"], other.actions, strict=True):
            assert (action["force"], action["moment"]) == (own.force.tolist(), own.moment.tolist())
            assert np.array_equal(action["ground"]["force"], product(R, own.force))
    assert [row["reactions"] + row["freedom"] for row in found["joints"]] == [6] * 4
    assert max(found["residual"].values()) <= 1e-14


def test_a_row_of_a_trajectory() -> None:
    outcome = run("fbd", *PUMA, "--traj", POLISH, "--time", "0.5013", "--format", "json")
    found = json.loads(outcome.out)
    assert found["state"] == f"row 51 of {POLISH} at 0.5 s, the nearest to 0.5013 s"
    with robodyn.read_motion(POLISH, model := robodyn.load(PUMA[0]), robodyn.load_scene(PUMA[2])) as reader:
        (block,) = reader.blocks()
    assert block.time[50] == 0.5
    assert list(found["q"].values()) == block.q[50].tolist()
    assert list(found["qdd"].values()) == block.qdd[50].tolist()
    tool = found["bodies"][-1]["actions"]
    (contact,) = (action for action in tool if action["kind"] == "external wrench")
    assert len(contact["force"]) == 3
    assert len(found["bodies"]) == len(model.bodies)


def test_drawings(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "svg"
    outcome = run("fbd", SCARA, "--svg", str(folder))
    assert outcome.out.endswith(f"written: 4 drawings in {folder}\n")
    names = sorted(path.name for path in folder.iterdir())
    assert names == ["00_base.svg", "01_inner_arm.svg", "02_outer_arm.svg", "03_spindle.svg"]
    before = [path.read_bytes() for path in sorted(folder.iterdir())]
    run("fbd", SCARA, "--svg", str(folder), "--format", "json")
    assert [path.read_bytes() for path in sorted(folder.iterdir())] == before


def test_a_folder_that_cannot_be_made_costs_nothing(tmp_path: Path) -> None:
    """What stands under its name stays, and so does a drawing that cannot be replaced."""
    taken = tmp_path / "taken"
    taken.write_text("mine")
    outcome = run("fbd", SCARA, "--svg", str(taken))
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == f"error: {taken}: cannot be written: file exists (name another folder)\n"
    assert taken.read_text() == "mine"
    folder = tmp_path / "folder"
    (folder / "01_inner_arm.svg").mkdir(parents=True)
    outcome = run("fbd", SCARA, "--svg", str(folder))
    assert outcome.err.startswith(f"error: {folder}/01_inner_arm.svg: cannot be written: ")
    assert sorted(path.name for path in folder.iterdir()) == ["00_base.svg", "01_inner_arm.svg"]


CALLS = [
    ((SCARA, "--time", "1"), "--time goes with --traj (try: robodyn fbd --help)"),
    ((SCARA, "--traj", "x.csv"), "--traj needs --time (try: robodyn fbd --help)"),
    ((SCARA, "--traj", "x.csv", "--time", "1", "--at", "1,2,3"), "--traj says all of the state: leave out --at, "),
    ((SCARA, "--at", "1,2"), f"{SCARA}: 2 values for 3 coordinates (in the order: 'shoulder', 'elbow', 'quill')"),
    ((SCARA, "--qd", "1,2"), f"{SCARA}: 2 values for 3 coordinates (in the order: 'shoulder', 'elbow', 'quill')"),
    ((SCARA, "--qdd", "elbwo=1"), f"{SCARA}: no joint 'elbwo' to set (did you mean 'elbow'?)"),
    (PUMA, "the scene needs columns of a trajectory: give --traj and --time (try: robodyn fbd --help)"),
    ((*PUMA, "--traj", POLISH, "--time", "99"), f"{POLISH}: time 99 s is outside the motion (it lasts from 0 s to "),
    ((*PUMA, "--traj", POLISH, "--time", "nan"), f"{POLISH}: time nan s is outside the motion"),
]


@pytest.mark.parametrize(("call", "line"), CALLS, ids=[" ".join(call[1:]) for call, _ in CALLS])
def test_wrong_calls(call: tuple[str, ...], line: str) -> None:
    outcome = run("fbd", *call)
    assert (outcome.status, outcome.out) == (2, "")
    assert len(outcome.err.splitlines()) == 1
    assert outcome.err.startswith(f"error: {line}")


def test_a_row_in_degrees_is_refused(tmp_path: Path) -> None:
    table = tmp_path / "degrees.csv"
    rows = (f"{0.1 * k},{60 * k},{-40 * k},0.1\n" for k in range(4))
    table.write_text("time,q_shoulder,q_elbow,q_quill\n" + "".join(rows))
    outcome = run("fbd", SCARA, "--traj", str(table), "--time", "0.2")
    assert (outcome.status, outcome.out) == (2, "")
    assert "are the angles degrees?" in outcome.err
    assert run("fbd", SCARA, "--traj", str(table), "--time", "0.2", "--angle-unit", "deg").status == 0
