"""`robodyn fbd`, `linearize`, `excite` and `export`: what they print and write."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.command_line import ROBOTS, refused, run, shown

import robodyn
from robodyn.errors import InputError
from robodyn.programs.vectors import product

SCARA = str(ROBOTS / "scara.urdf")
POLISHED = (str(ROBOTS / "puma.urdf"), "--scene", str(ROBOTS / "puma_polish.toml"))
POLISH = str(ROBOTS / "puma_polish.csv")
PUMA, PLANAR, PENDULUM = (str(ROBOTS / f"{name}.urdf") for name in ("puma", "two_link_planar", "pendulum"))
SERVO = (PUMA, "--scene", str(ROBOTS / "puma_servo.toml"))
QUICK = ("--harmonics", "2", "--rate", "20")
GRIPPER = str(ROBOTS / "gripper.urdf")


def test_fbd() -> None:
    text = shown("fbd", SCARA, "--at", "0.3,-0.5,0.05", "--qd", "quill=0.1", "--qdd", "elbow=2")
    assert "scara: 4 bodies, as given, moving, accelerating, gravity (0, 0, -9.81) m/s^2" in text
    assert "4 bodies x 6 equations = 24 = 21 reactions + 3 along the degrees of freedom" in text
    sums = [line.split() for line in text.splitlines() if line.startswith("sum")]
    assert sums == [["sum", *"000000"]] * 4
    assert "reaction, elbow" in text


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
    outcome = run("fbd", *POLISHED, "--traj", POLISH, "--time", "0.5013", "--format", "json")
    found = json.loads(outcome.out)
    assert found["state"] == f"row 51 of {POLISH} at 0.5 s, the nearest to 0.5013 s"
    with robodyn.read_motion(POLISH, model := robodyn.load(POLISHED[0]), robodyn.load_scene(POLISHED[2])) as reader:
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
    refused(run("fbd", SCARA, "--svg", str(taken)), f"{taken}: cannot be written: file exists (name another folder)\n")
    assert taken.read_text() == "mine"
    folder = tmp_path / "folder"
    (folder / "01_inner_arm.svg").mkdir(parents=True)
    refused(run("fbd", SCARA, "--svg", str(folder)), f"{folder}/01_inner_arm.svg: cannot be written: ")
    assert sorted(path.name for path in folder.iterdir()) == ["00_base.svg", "01_inner_arm.svg"]


def test_linearize() -> None:
    text = shown("linearize", PLANAR, "--equilibrium", "--at", "-1.5,-0.1")
    assert text.startswith("two_link_planar: linear about an equilibrium, 4 states, 2 inputs\n")
    assert "oscillates, undamped" in text
    assert "elbow 1, shoulder 0.317 against\n" in text
    assert "Neither stable nor unstable: 2 modes are not damped within rounding.\n" in text
    held = shown("linearize", PLANAR)
    assert "it is no equilibrium: torques added hold it; --equilibrium looks for a state without them" in held
    assert "  41.69   N m\n" in held
    stable = shown("linearize", *SERVO, "--equilibrium")
    assert (
        "\nStable: every small push dies away.\nThe slowest decays to 1/e in 0.09297 s, a margin of 10.76 /s.\n"
        in stable
    )
    assert "warning: drives of 'elbow', 'shoulder', 'waist' follow a table" in stable
    upright = shown("linearize", PENDULUM, "--at", "1.5707963267948966", "--equilibrium")
    assert "\nUnstable: 1 mode grows.\nThe fastest grows by a factor of e in 0.3193 s.\n" in upright
    assert "No verdict on stability: the state moves." in shown("linearize", PUMA, "--qd", "1,2,3")


def test_file_and_document_have_the_same_numbers(tmp_path: Path) -> None:
    out = tmp_path / "linear.npz"
    found = json.loads(
        shown("linearize", *SERVO, "--equilibrium", "--step", "0.001", "--out", str(out), "--format", "json")
    )
    scene = robodyn.load_scene(SERVO[2])
    library = robodyn.linearize(robodyn.load(PUMA), scene, equilibrium=True, step=0.001)
    with np.load(out) as file:
        assert sorted(file) == ["A", "B", "drive", "held", "inputs", "q", "qd", "states"]
        for name in ("A", "B"):
            assert file[name].tolist() == found[name] == getattr(library, name).tolist()
        names = ["waist", "shoulder", "elbow"]
        states = [f"{kind}_{name}" for kind in ("q", "qd") for name in names]
        assert file["states"].tolist() == found["states"] == states
        assert file["inputs"].tolist() == found["inputs"] == [f"tau_{name}" for name in names]
        assert file["q"].tolist() == found["equilibrium"]["q"]
    assert (found["step"], found["stable"], found["verdict"]) == (0.001, True, "stable")
    assert found["margin"] == -max(mode["real"] for mode in found["modes"])
    assert [mode["real"] for mode in found["modes"]] == [mode.real for mode in library.modes.modes]
    # the steps' eigenvalues are exp(eigenvalue step)
    values = np.exp(0.001 * np.array([mode["real"] for mode in found["modes"]]))
    assert np.abs(np.sort(np.linalg.eigvals(library.A).real) - np.sort(values)).max() <= 1e-12


def test_excite(tmp_path: Path) -> None:
    file = tmp_path / "motion.csv"
    outcome = run("excite", PENDULUM, *QUICK, "--period", "4", "--out", str(file))
    assert outcome.status == 0, outcome.err
    words = " ".join(outcome.out.split())
    assert "pendulum: a motion of 1 joint that shows 6 base parameters" in words
    assert "period 4 s, 2 harmonics, 81 rows at 20 /s" in words
    assert "note: 1 joint (pivot): no position limits: 3.142 rad to each side" in words
    assert f"written: {file}, 81 rows of time and 3 columns" in words
    with file.open() as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0]) == ["time", "q_pivot", "qd_pivot", "qdd_pivot"]
    assert [float(rows[k]["time"]) for k in (0, 1, -1)] == [0.0, 0.05, 4.0]
    assert abs(float(rows[-1]["qd_pivot"])) < 1e-12
    torques = run("torques", PENDULUM, str(file), "--fail-on-limits")
    assert torques.status == 0, torques.out + torques.err


def test_json_of_excite_is_what_the_file_has(tmp_path: Path) -> None:
    file = tmp_path / "motion.csv"
    call = ("excite", PLANAR, *QUICK, "--joints", "elbow", "--noise", "0.2", "--max-acceleration", "5")
    found = json.loads(run(*call, "--format", "json", "--out", str(file)).out)
    assert [joint["moves"] for joint in found["joints"]] == [False, True]
    assert [joint["noise"] for joint in found["joints"]] == [0.2, 0.2]
    assert found["joints"][1]["acceleration"] <= found["joints"][1]["acceleration_limit"] == 5
    elbow = found["joints"][1]
    with file.open() as stream:
        first = next(csv.DictReader(stream))
    assert float(first["q_elbow"]) == pytest.approx(elbow["centre"] + sum(elbow["cosine"]), abs=1e-9)
    assert "shoulder.viscous" in found["invisible"]
    assert found["rank"] == len(found["base_parameters"])


@pytest.mark.parametrize("target", ["c", "torch"])
def test_it_writes_what_the_library_returns(target: str, tmp_path: Path) -> None:
    out = tmp_path / "gripper.txt"
    scene = str(ROBOTS / "gripper.toml")
    call = ("export", GRIPPER, "--to", target, "--what", "bias,torques", "--scene", scene)
    written = run(*call, "--out", str(out))
    assert (written.status, written.err) == (0, "")
    assert written.out.startswith(f"written: {out}, ")
    text = robodyn.export(robodyn.load(GRIPPER), target, ["bias", "torques"], scene=robodyn.load_scene(scene))
    assert out.read_text() == text
    assert run(*call).out == text


@pytest.mark.parametrize(
    ("robot", "target", "more", "line"),
    [
        ("scara", "rust", {}, "there is no target 'rust' to export"),
        ("scara", ["c"], {}, r"there is no target \['c'\] to export"),
        ("scara", "c", {"what": ["inverse_dynamics"]}, "there is no function 'inverse_dynamics' to export"),
        ("scara", "c", {"what": None}, "there is no function None to export"),
        ("scara", "c", {"what": []}, "no function to export is named"),
        ("scara", "c", {"scene": {}}, "scene is no scene but of type dict"),
        ("composite", "c", {}, "nothing can move"),
    ],
)
def test_wrong_calls_of_the_library(robot: str, target: Any, more: dict[str, Any], line: str) -> None:
    with pytest.raises(InputError, match=line):
        robodyn.export(robodyn.load(ROBOTS / f"{robot}.urdf"), target, **more)
