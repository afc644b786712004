"""`robodyn equations`: what it prints, and how it refuses."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
import sympy
from helpers.command_line import ROBOTS, run

import robodyn

PUMA, GRIPPER, PLANAR = (str(ROBOTS / f"{name}.urdf") for name in ("puma", "gripper", "two_link_planar"))
SCENE = ("--scene", str(ROBOTS / "gripper.toml"))


def shown(*call):
    outcome = run("equations", *call)
    assert (outcome.status, outcome.err) == (0, "")
    return outcome.out


def test_text():
    text = shown(GRIPPER, *SCENE, "--at", "0.1,0.2,0.01", "--qd", "wrist=-1")
    titles = [part.splitlines()[0] for part in text.rstrip("\n").split("\n\n")]
    assert titles == [
        "gripper: 3 coordinates, the base is bolted down, gravity (0, 0, -9.81) m/s^2",
        "Configuration",
        "Mass matrix M(q) [kg m^2, kg m or kg]",
        "What tau must supply where nothing accelerates",
    ]
    assert re.search(r"^wrist +0\.2 +-1$", text, re.MULTILINE)
    assert re.search(r"^joint +gravity +coriolis +payload +viscous friction .* together +unit$", text, re.MULTILINE)
    assert re.search(r"^Condition number \d+\.\d$", text, re.MULTILINE)


@pytest.mark.parametrize("form", ["ode", "closed", "dae"])
def test_whether_the_base_is_held_is_said(form):
    """A description does not say it, and of a satellite it is wrong."""
    satellite = str(ROBOTS / "satellite.urdf")
    assert ", the base is bolted down, " in run("equations", satellite, "--form", form).out.splitlines()[0]
    if form == "ode":
        scene = str(ROBOTS / "satellite.toml")
        assert ", the base moves, " in run("equations", satellite, "--scene", scene).out.splitlines()[0]


def test_json():
    found = json.loads(
        shown(PUMA, "--at", "0.1,-0.5,0.3", "--qd", "1,0,-2", "--gravity", "0,0,-1.62", "--format", "json")
    )
    assert list(found) == [
        *("robot", "form", "gravity", "coordinates", "rates", "units", "q", "qd", "M", "condition", "bias", "shares"),
        "warnings",
    ]
    model, scene = robodyn.load(PUMA), robodyn.Scene(gravity=(0, 0, -1.62))
    q, qd = found["q"], found["qd"]
    assert (q, qd) == ([0.1, -0.5, 0.3], [1, 0, -2])
    assert found["M"] == robodyn.mass_matrix(model, q).tolist()
    assert found["bias"] == robodyn.bias_forces(model, q, qd, scene=scene).tolist()
    assert np.allclose(np.sum(list(found["shares"].values()), axis=0), found["bias"], rtol=0, atol=1e-14)


def test_a_singular_mass_matrix_is_valid_json(tmp_path):
    robot = tmp_path / "r.urdf"
    robot.write_text(
        '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="continuous"><parent link="a"/>'
        '<child link="b"/></joint></robot>'
    )
    assert json.loads(shown(str(robot), "--format", "json"))["condition"] is None
    assert "M is singular to working precision" in shown(str(robot))


def test_closed_text_and_json_say_the_same():
    lines = dict(line.split(" = ") for line in shown(PLANAR, "--form", "closed").splitlines() if "] = " in line)
    found = json.loads(shown(PLANAR, "--form", "closed", "--format", "json"))
    assert list(found) == ["robot", "form", "gravity", "joints", "M", "shares", "check"]
    assert found["joints"][0] == {"name": "shoulder", "kind": "revolute", "q": "q_shoulder", "qd": "qd_shoulder"}
    pairs = [(lines["M[1,2]"], found["M"][0][1]), (lines["gravity[1]"], found["shares"]["gravity"][0])]
    pairs.append((lines["coriolis[2]"], found["shares"]["coriolis"][1]))
    for text, exact in pairs:
        assert sympy.nsimplify(sympy.sympify(text), rational=True) == sympy.sympify(exact)
    assert found["check"]["not_simplified"] == 0
    assert found["check"]["largest_difference"] <= 1e-12


def test_latex():
    assert "M_{12} &= 0.5 c_{2} + 0.4 \\\\\n" in shown(PLANAR, "--form", "closed", "--format", "latex")


def test_standard_input():
    with open(PLANAR, "rb") as file:
        outcome = run("equations", "-", "--form", "closed", stdin=file.read())
    assert outcome.status == 0
    assert outcome.out == shown(PLANAR, "--form", "closed")


CALLS = {
    "--format latex": "--format latex is for --form closed or dae (try: robodyn equations --help)",
    "--form closed --at 1,2,3": "--at is for numbers: --form ode or dae as text or json (try",
    "--format c": "invalid value for '--format': 'c' is not one of 'text', 'latex', 'json'; robodyn export --to c "
    "writes C (try: robodyn equations --help)",
    "--form dae --format latex --tau 1,2,3": "--tau is for numbers: --form ode or dae as text or json (try",
    "--tau 1,2,3": "--tau is for --form dae (try",
    "--form dae --tau elbw=1": "{}: no joint 'elbw' to set (did you mean 'elbow'?)",
    "--at 1,2": "{}: 2 values for 3 coordinates (in the order: 'waist', 'shoulder', 'elbow')",
    "--at elbw=1": "{}: no joint 'elbw' to set (did you mean 'elbow'?)",
    "--at 1;2": "invalid value for '--at': '1;2' is neither numbers",
    "--form lagrange": "invalid value for '--form': 'lagrange' is not one of 'ode', 'dae', 'closed'",
}


@pytest.mark.parametrize("call", CALLS)
def test_wrong_calls(call):
    refused(run("equations", PUMA, *call.split()), CALLS[call].format(PUMA))


def refused(outcome, line):
    assert (outcome.status, outcome.out) == (2, "")
    assert len(outcome.err.splitlines()) == 1, outcome.err
    assert outcome.err.startswith(f"error: {line}"), outcome.err


def test_wrong_robots():
    composite, free = str(ROBOTS / "composite.urdf"), str(ROBOTS / "rigid_body.urdf")
    refused(run("equations", composite), f"{composite}: nothing can move: the robot has no joint that moves")
    refused(run("equations", free, "--form", "closed"), f"{free}: a floating joint has no closed form here")
    polish = str(ROBOTS / "puma_polish.toml")
    refused(run("equations", PUMA, "--scene", polish), "the scene's wrenches name columns of a trajectory: ")
