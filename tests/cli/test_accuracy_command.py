"""`robodyn accuracy`: what it prints, and how it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS, run

from robodyn.simulation.methods import METHODS

BRACKET = str(ROBOTS / "meshes" / "bracket.stl")
SCARA = (str(ROBOTS / "scara.urdf"), str(ROBOTS / "scara_pick_and_place.csv"))
PLANAR = (str(ROBOTS / "two_link_planar.urdf"), str(ROBOTS / "two_link_planar_swing_down.toml"))


@pytest.fixture(autouse=True)
def _short_ladders(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robodyn.measure.accuracy.simulation.STEPS", (1.6e-2, 4e-3))
    monkeypatch.setattr("robodyn.measure.accuracy.simulation.TOLERANCES", (1e-4, 1e-8))


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


@pytest.mark.slow
def test_a_scene_may_be_named_as_for_simulate() -> None:
    calls = ((*PLANAR, "--duration", "0.05"), (PLANAR[0], "--scene", PLANAR[1], "--duration", "0.05"))
    found = [json.loads(run("accuracy", *call, "--format", "json").out) for call in calls]
    errors = [[method["errors"] for method in one["ladders"][0]["methods"]] for one in found]
    assert errors[0] == errors[1]


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
        (
            (BRACKET, "--gravity", "0,0,1"),
            "--scene, --payload, --gravity, --package-path, --xacro-arg and --trust-xacro are for robots",
        ),
        ((BRACKET, "--target", "-1"), "invalid value for '--target': -1 is no positive finite number"),
        ((BRACKET, "--target", "nan"), "invalid value for '--target': nan is no positive finite number"),
        (("no.stl",), "no.stl: there is no such file"),
        ((SCARA[0], "no.csv"), "no.csv: cannot be read"),
        ((str(ROBOTS / "meshes" / "worn_pad.stl"), "--format", "xml"), "invalid value for '--format'"),
        ((*PLANAR, "--scene", PLANAR[1]), "the scene is given twice"),
        ((*SCARA, "--duration", "1"), "--duration and --traj are for a URDF and a scene"),
        ((BRACKET, "--plot", "front.bmp"), "front.bmp: unknown type of picture by this suffix"),
        ((BRACKET, "--plot", BRACKET), f"{BRACKET}: the output would overwrite an input"),
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


def test_simulation(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("mpmath")
    monkeypatch.setattr("robodyn.measure.accuracy.simulation.STEPS", (4e-3,))
    monkeypatch.setattr("robodyn.measure.accuracy.simulation.TOLERANCES", (1e-4,))
    few = tuple(method for method in METHODS if method.name in ("rk4", "verlet", "dop853"))
    monkeypatch.setattr("robodyn.measure.accuracy.simulation.METHODS", few)
    plot = tmp_path / "front.svg"
    outcome = run("accuracy", *PLANAR, "--duration", "0.05", "--plot", str(plot), "--target", "1e-5")
    assert (outcome.status, outcome.err) == (0, "")
    assert "two_link_planar, 0.05 s: simulation, errors against gauss6 and dop853, which agree to" in outcome.out
    assert outcome.out.endswith(f"\nwritten: {plot}\n")
    picture = plot.read_text()
    assert all(f">{text}<" in picture for text in ("rk4", "dop853", "front", "target 1e-05", "largest error"))
    assert [path.name for path in tmp_path.iterdir()] == ["front.svg"]
    data = run("accuracy", *PLANAR, "--duration", "0.05", "--format", "json", "--plot", str(tmp_path / "a.png"))
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    (ladder,) = json.loads(data.out)["ladders"]
    assert list(ladder["methods"][0]["errors"]) == ["end", "way"]
    assert {"evaluations", "drift"} <= ladder["methods"][0].keys()


def test_a_simulation_as_accurate_as_asked() -> None:
    call = ("simulate", PLANAR[0], "--scene", PLANAR[1], "--duration", "0.1", "--accuracy", "1e-7")
    outcome = run(*call)
    assert (outcome.status, outcome.err) == (0, "")
    assert "\nnote: accuracy: 1e-07 asked, " in outcome.out
    found = json.loads(run(*call, "--format", "json").out)["accuracy"]
    assert found["target"] == 1e-7 >= found["expected"]
    refused = run(*call[:-3], "0.01", "--accuracy", "1e-18")
    assert (refused.status, refused.out) == (2, "")
    assert refused.err.startswith("error: an accuracy of 1e-18 cannot be promised: ")
    both = run(*call, "--method", "rk4")
    assert both.err.startswith("error: --accuracy chooses method, step and tolerance")
