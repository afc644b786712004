"""`robodyn linearize`: text, JSON, .npz, and how it refuses."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run

import robodyn

PUMA, PLANAR, PENDULUM = (str(ROBOTS / f"{name}.urdf") for name in ("puma", "two_link_planar", "pendulum"))
SERVO = (PUMA, "--scene", str(ROBOTS / "puma_servo.toml"))


def shown(*call: str) -> str:
    outcome = run("linearize", *call)
    assert (outcome.status, outcome.err) == (0, "")
    return outcome.out


def test_words() -> None:
    text = shown(PLANAR, "--equilibrium", "--at", "-1.5,-0.1")
    assert text.startswith("two_link_planar: linear about an equilibrium, 4 states, 2 inputs\n")
    assert "oscillates, undamped" in text
    assert "elbow 1, shoulder 0.317 against\n" in text
    assert "Neither stable nor unstable: 2 modes are not damped within rounding.\n" in text
    held = shown(PLANAR)
    assert (
        "it is no equilibrium: constant torques are added that hold it, 41.69 N m at shoulder the largest; --equil"
        in held
    )
    stable = shown(*SERVO, "--equilibrium")
    assert (
        "\nStable: every small push dies away.\nThe slowest decays to 1/e in 0.09297 s, a margin of 10.76 /s.\n"
        in stable
    )
    assert "warning: drives of 'elbow', 'shoulder', 'waist' follow a table" in stable
    upright = shown(PENDULUM, "--at", "1.5707963267948966", "--equilibrium")
    assert "\nUnstable: 1 mode grows.\nThe fastest grows by a factor of e in 0.3193 s.\n" in upright
    assert "No verdict on stability: the state moves." in shown(PUMA, "--qd", "1,2,3")


def test_file_and_document_have_the_same_numbers(tmp_path: Path) -> None:
    out = tmp_path / "linear.npz"
    found = json.loads(shown(*SERVO, "--equilibrium", "--step", "0.001", "--out", str(out), "--format", "json"))
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


CALLS = {
    "--out {folder}/linear.csv": "{folder}/linear.csv: is no .npz file (--out FILE.npz)",
    "--out {folder}/no/linear.npz": "{folder}/no/linear.npz: cannot be written: no such file or directory (",
    "--report {folder}/linear.pdf": "{folder}/linear.pdf: unknown type of report by this suffix (name it .html or .md)",
    "--step 0": "invalid value for '--step': 0 is no positive finite number (try: robodyn linearize --help)",
    "--at elbw=1": "{puma}: no joint 'elbw' to set (did you mean 'elbow'?)",
    "--at 1,2": "{puma}: 2 values for 3 coordinates (in the order: 'waist', 'shoulder', 'elbow')",
    "--at 1,2,1e400": "invalid value for '--at'",
    "--qd waist=1 --equilibrium": "an equilibrium is at rest (leave out the speeds, or do not look for one)",
    "--scene {folder}/gone.toml": "{folder}/gone.toml: cannot be read: no such file or directory (check the name)",
    "--scene {folder}/columns.toml": "the scene's wrenches name columns of a trajectory: ",
    "--scene {folder}/tilt.toml --equilibrium": "there is no equilibrium: 5 N m at waist stay unbalanced at every ",
    "--scene {folder}/loop.toml": "{folder}/loop.toml: [[loop]] 'pin': the robot has no link 'no' (links: ",
}


@pytest.mark.parametrize("call", CALLS)
def test_wrong_calls(call: str, tmp_path: Path) -> None:
    files = {
        "columns": '[[wrench]]\nlink = "forearm"\nforce = ["fx", 0, 0]\n',
        "tilt": "[drive]\nwaist = { torque = 5 }\n",
        "loop": '[[loop]]\nname = "pin"\nlink = "no"\n',
    }
    for name, text in files.items():
        (tmp_path / f"{name}.toml").write_text(text)
    outcome = run("linearize", PUMA, *call.format(folder=tmp_path).split())
    assert (outcome.status, outcome.out) == (2, "")
    assert len(outcome.err.splitlines()) == 1, outcome.err
    assert outcome.err.startswith(f"error: {CALLS[call].format(folder=tmp_path, puma=PUMA)}"), outcome.err
    assert sorted(os.listdir(tmp_path)) == [f"{name}.toml" for name in sorted(files)]


def test_an_output_does_not_overwrite_the_robot(tmp_path: Path) -> None:
    robot = tmp_path / "puma.npz"
    robot.write_bytes(Path(PUMA).read_bytes())
    outcome = run("linearize", str(robot), "--out", str(robot))
    assert (outcome.status, robot.read_bytes()) == (2, Path(PUMA).read_bytes())
