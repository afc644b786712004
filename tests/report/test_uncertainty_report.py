"""What reports say of uncertain parameters: error bars, what makes them, probabilities of verdicts."""

from __future__ import annotations

import json
import re

import pytest
from helpers.command_line import run
from helpers.oracles import ROBOTS

from robodyn.report.uncertainty import parameter, probability, ranks

ARM, MOTION = str(ROBOTS / "puma560.urdf"), str(ROBOTS / "puma560_sweep.csv")
SCENE = str(ROBOTS / "puma560_uncertain.toml")
BARE = str(ROBOTS / "puma560_sizing.toml")


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
    text = run("torques", ARM, MOTION, "--scene", SCENE, "--samples", "5").out
    data = json.loads(run("torques", ARM, MOTION, "--scene", SCENE, "--format", "json").out)["uncertainty"]
    for joint in data["joints"]:
        peak, rms = joint["load"]["peak"], joint["load"]["rms"]
        found = numbers_of(text, "Joints: error bars", joint["load"]["name"])
        assert len(found) == 10, "with the errors of motions that are run again"
        expected = [peak["value"], peak["standard_error"], peak["low"], peak["high"]]
        assert found[:4] == pytest.approx(expected, rel=0.05)
        assert found[5:9] == pytest.approx([rms["value"], rms["standard_error"], rms["low"], rms["high"]], rel=0.05)
        assert sum(joint["load"]["shares"].values()) == pytest.approx(1.0)
    assert data["suffices"] < 0.95
    assert f"all joints   suffice with {100 * data['suffices']:.0f} %" in text
    assert "Run again: standard errors of 5 motions" in text
    assert "with the parameters as they are given" in text
    assert "probability of" in text


def test_the_page_has_it_too(tmp_path):
    page = tmp_path / "o.html"
    assert run("torques", ARM, MOTION, "--scene", SCENE, "--report", str(page)).status == 0
    text = page.read_text(encoding="utf-8")
    for said in ("Uncertain parameters", "All limits are kept with", "Which parameters matter most", "mass of forearm"):
        assert said in text


def test_without_uncertainty_nothing_is_said():
    assert "error bars" not in run("torques", ARM, MOTION, "--scene", BARE).out
    assert "uncertainty" not in json.loads(run("torques", ARM, MOTION, "--scene", BARE, "--format", "json").out)


def test_samples_need_uncertain_parameters():
    outcome = run("torques", ARM, MOTION, "--scene", BARE, "--samples", "10")
    assert (outcome.status, len(outcome.err.splitlines())) == (2, 1)
    assert 'write [uncertainty] mass = "5 %" in a scene' in outcome.err
