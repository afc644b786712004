"""Words of reports on uncertain parameters, modes and joints that do nothing."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import run
from helpers.oracles import ROBOTS

from robodyn.equations.linearized.modes import Mode
from robodyn.report.linearized import moves
from robodyn.report.measured import bar
from robodyn.report.uncertainty import parameter, probability, ranks

ARM, MOTION = str(ROBOTS / "puma560.urdf"), str(ROBOTS / "puma560_sweep.csv")
SCENE = str(ROBOTS / "puma560_uncertain.toml")


@pytest.mark.parametrize(
    ("p", "said"),
    [
        (1.0, "more than 99.9 %"),
        (0.9995, "more than 99.9 %"),
        (0.994, "99.4 %"),
        (0.98, "98 %"),
        (0.5, "50 %"),
        (0.004, "0.4 %"),
        (0.0, "less than 0.1 %"),
    ],
)
def test_probabilities_are_told_as_precisely_as_they_are_known(p, said):
    assert probability(p) == said


def test_parameters_in_words():
    assert parameter("fore.arm.mass") == "mass of fore.arm"
    assert parameter("elbow.friction") == "friction of elbow"
    assert parameter("forearm.com") == "centre of mass of forearm"
    assert parameter("forearm.Ixx") == "forearm.Ixx"
    assert ranks({"forearm.mass": 0.61, "elbow.friction": 0.385, "hand.com": 0.005}) == (
        "mass of forearm 61 %, friction of elbow 38 %"
    )
    assert ranks({}) == "-"


def numbers_of(text, title, joint):
    """The numbers of a joint's row in the table of this title."""
    lines = text.partition(title)[2].splitlines()
    row = next(line for line in lines if line.startswith(f"{joint} "))
    return [float(x) for x in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", row.removeprefix(joint))]


def test_text_says_what_json_says():
    text = run("torques", ARM, MOTION, "--scene", SCENE).out
    data = json.loads(run("torques", ARM, MOTION, "--scene", SCENE, "--format", "json").out)["uncertainty"]
    for joint in data["joints"]:
        peak, rms = joint["load"]["peak"], joint["load"]["rms"]
        found = numbers_of(text, "Joints: error bars", joint["load"]["name"])
        assert len(found) == 8
        expected = [peak["value"], peak["standard_error"], peak["low"], peak["high"]]
        assert found[:4] == pytest.approx(expected, rel=0.05)
        assert found[4:8] == pytest.approx([rms["value"], rms["standard_error"], rms["low"], rms["high"]], rel=0.05)
        assert sum(joint["load"]["shares"].values()) == pytest.approx(1.0)
    assert data["suffices"] < 0.95
    assert f"all joints   suffice with {100 * data['suffices']:.0f} %" in text
    assert "with the parameters as they are given" in text
    assert "probability of" in text


def test_the_page_has_it_too(tmp_path):
    page = tmp_path / "o.html"
    assert run("torques", ARM, MOTION, "--scene", SCENE, "--report", str(page)).status == 0
    text = page.read_text(encoding="utf-8")
    for said in ("uncertain parameter", "All limits are kept with", "Which parameters matter most", "mass of forearm"):
        assert said in text


@pytest.mark.parametrize(
    ("shape", "shares", "words"),
    [
        ((1.0, 0.5), (1.0, 0.2), "a 1, b 0.5"),
        ((-0.25, 1.0), (0.01, 1.0), "b 1, a 0.25 against"),
        ((1.0, 31.0), (1.0, 0.7), "a 1, b 31"),
        ((0.02, 1.0, 40.0), (0.5, 1.0, 0.9), "b 1, c 40"),
        ((1.0, 0.01), (1.0, 0.9), "a 1"),
        ((1.0, 0.5j, -0.5j), (1.0, 0.3, 0.2), "a 1, b 0.5 ahead by 90 deg, c 0.5 behind by 90 deg"),
    ],
)
def test_who_moves_how_much(shape, shares, words):
    """The first is the one that the others are measured by, whatever their units."""
    mode = Mode(-1.0, 2.0, 0.0, tuple(map(complex, shape)), shares)
    assert moves("abc"[: len(shape)], mode) == words


LINK = """<link name="{0}"><inertial><origin xyz="0.3 0 0"/><mass value="{1}"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>"""
JOINT = """<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/><origin rpy="{3:.{digits}f} 0 0"/>
<axis xyz="0 0 1"/><limit effort="500" velocity="5" lower="-3" upper="3"/></joint>"""


@pytest.mark.parametrize("digits", [9, 12, 15])
@pytest.mark.parametrize("mass", [1.0, 20.0])
def test_a_joint_that_does_nothing(digits: int, mass: float, tmp_path: Path) -> None:
    """Its axis is vertical but for the digits of a right angle, and it stands still beside one that moves."""
    quarter = np.pi / 2
    links = "".join(LINK.format(*each) for each in (("lift", 10.0 * mass), ("turn", mass)))
    joints = JOINT.format("first", "base", "lift", quarter, digits=digits)
    joints += JOINT.format("idle", "lift", "turn", -quarter, digits=digits)
    (tmp_path / "r.urdf").write_text(f'<robot name="r"><link name="base"/>{links}{joints}</robot>')
    time = np.arange(0.0, 2.0, 0.01)
    q = 0.2 * np.sin(3.0 * time)
    table = np.column_stack((time, q, 0.6 * np.cos(3.0 * time), -1.8 * np.sin(3.0 * time), *([0.0 * time] * 3)))
    head = "time,q_first,qd_first,qdd_first,q_idle,qd_idle,qdd_idle"
    table[:, 1:4] *= [[0.0, 0.0, 0.0]] if mass == 1.0 else [[1.0, 1.0, 1.0]]
    np.savetxt(tmp_path / "m.csv", table, delimiter=",", header=head, comments="")
    out = run("torques", str(tmp_path / "r.urdf"), str(tmp_path / "m.csv"), "--sizing").out
    if mass == 1.0:
        row = next(line for line in out.splitlines() if line.startswith("idle "))
        assert re.split(r"  +", row)[1].split()[0] == "0"
    assert not re.search(r"e-(0[89]|1\d) (N m|%)", out)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_errors_of_nothing_are_zero(scale: float) -> None:
    assert bar(4.2e-13 * scale, 4.2e-13 * scale, scale) == "0"
    assert bar(4.2e-3 * scale, 4.2e-4 * scale, scale) != "0"
