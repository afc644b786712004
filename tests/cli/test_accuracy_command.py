"""`robodyn accuracy`: what it prints, and how it refuses."""

from __future__ import annotations

import json

import pytest
from command_line import ROBOTS, run
from hurried import hurry

BRACKET = str(ROBOTS / "meshes" / "bracket.stl")
SCARA = (str(ROBOTS / "scara.urdf"), str(ROBOTS / "scara_pick_and_place.csv"))


@pytest.fixture(autouse=True)
def _hurry(monkeypatch: pytest.MonkeyPatch) -> None:
    hurry(monkeypatch)
    monkeypatch.setattr("robodyn.accuracy.timing.BUDGET", 0.0)
    monkeypatch.setattr("robodyn.accuracy.timing.ROUNDS", 1)


def test_mesh_as_text() -> None:
    outcome = run("accuracy", BRACKET, "--target", "1e-6")
    assert (outcome.status, outcome.err) == (0, "")
    assert "errors against exact rationals\n" in outcome.out
    assert "\ncheapest within 1e-06: integral, " in outcome.out
    assert "\nproof that it is closed " in outcome.out
    assert "dominated by " in outcome.out


def test_mesh_as_json() -> None:
    found = json.loads(run("accuracy", BRACKET, "--target", "1e-12", "--format", "json").out)
    assert list(found) == ["name", "target", "ladders", "prices", "effects", "notes"]
    (ladder,) = found["ladders"]
    assert list(ladder) == ["title", "reference", "per", "methods", "front", "cheapest"]
    methods = {each["name"]: each for each in ladder["methods"]}
    assert methods[ladder["cheapest"]]["error"] <= 1e-12
    times = [methods[name]["time"]["median"] for name in ladder["front"]]
    errors = [methods[name]["error"] for name in ladder["front"]]
    assert times == sorted(times)
    assert errors == sorted(errors, reverse=True)
    assert {each["name"] for each in ladder["methods"] if each["dominated_by"] is None} == set(ladder["front"])


def test_robot() -> None:
    pytest.importorskip("mpmath")
    outcome = run("accuracy", *SCARA)
    assert (outcome.status, outcome.err) == (0, "")
    assert "scara: torques per sample, errors against 50 digits on 16 of " in outcome.out
    assert "\nEffects\nwithout" in outcome.out


def test_a_target_beyond_reach() -> None:
    outcome = run("accuracy", BRACKET, "--target", "1e-300")
    assert outcome.status == 1
    assert "\nno method reaches 1e-300; the best error is " in outcome.out


@pytest.mark.parametrize(
    ("call", "line"),
    [
        ((), "missing argument 'MESH|URDF TRAJECTORY|URDF SCENE.toml' (try: robodyn accuracy --help)"),
        ((SCARA[0],), "give one mesh, a URDF and a trajectory, or a URDF and a scene"),
        ((BRACKET, *SCARA), "give one mesh, a URDF and a trajectory, or a URDF and a scene"),
        ((BRACKET, "--gravity", "0,0,1"), "--scene and --gravity are for robots, not for a mesh"),
        ((BRACKET, "--target", "-1"), "invalid value for '--target': -1 is no positive finite error"),
        ((BRACKET, "--target", "nan"), "invalid value for '--target': nan is no positive finite error"),
        (("no.stl",), "no.stl: there is no such file"),
        ((SCARA[0], "no.csv"), "no.csv: cannot be read"),
        ((str(ROBOTS / "meshes" / "worn_pad.stl"), "--format", "xml"), "invalid value for '--format'"),
    ],
)
def test_wrong_calls(call: tuple[str, ...], line: str) -> None:
    outcome = run("accuracy", *call)
    assert (outcome.status, outcome.out) == (2, "")
    assert len(outcome.err.splitlines()) == 1
    assert outcome.err.startswith(f"error: {line}"), outcome.err


def test_robot_as_json() -> None:
    pytest.importorskip("mpmath")
    found = json.loads(run("accuracy", *SCARA, "--format", "json").out)
    assert [ladder["title"] for ladder in found["ladders"]] == ["torques", "derivatives", "sample rate"]
    assert {ladder["per"] for ladder in found["ladders"]} == {"sample"}
    assert list(found["effects"][0]) == ["name", "torque", "unit", "joint", "saved"]
    assert found["prices"][0]["name"] == "tracing the recursion"
    assert found["target"] is None
