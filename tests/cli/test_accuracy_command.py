"""`robodyn accuracy`: what it prints, and how it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS, refused, run, shown

from robodyn.simulation.methods import METHODS

BRACKET = str(ROBOTS / "meshes" / "bracket.stl")
SCARA = (str(ROBOTS / "scara.urdf"), str(ROBOTS / "scara_pick_and_place.csv"))
PLANAR = (str(ROBOTS / "two_link_planar.urdf"), str(ROBOTS / "two_link_planar_swing_down.toml"))


@pytest.fixture(autouse=True)
def _short_ladders(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robodyn.measure.accuracy.simulation.STEPS", (1.6e-2, 4e-3))
    monkeypatch.setattr("robodyn.measure.accuracy.simulation.TOLERANCES", (1e-4, 1e-8))
    monkeypatch.setattr("robodyn.measure.accuracy.ladder.SPREAD_BUDGET", 0.0)


def test_mesh_as_text() -> None:
    text = shown("accuracy", BRACKET, "--target", "1e-6")
    assert "errors against exact rationals\n" in text
    assert "\ncheapest within 1e-06: integral, " in text
    assert "\nproof that it is closed " in text
    assert "dominated by " in text


def test_mesh_as_json() -> None:
    (ladder,) = json.loads(run("accuracy", BRACKET, "--target", "1e-12", "--format", "json").out)["ladders"]
    methods = {each["name"]: each for each in ladder["methods"]}
    assert methods[ladder["cheapest"]]["error"] <= 1e-12
    assert {each["name"] for each in ladder["methods"] if each["dominated_by"] is None} == set(ladder["front"])


@pytest.mark.slow
def test_robot() -> None:
    pytest.importorskip("mpmath")
    text = shown("accuracy", *SCARA)
    assert "scara: torques per sample, errors against 50 digits on 16 of " in text
    assert "\nEffects\nwithout" in text


def test_a_target_beyond_reach() -> None:
    outcome = run("accuracy", BRACKET, "--target", "1e-300")
    assert outcome.status == 1
    assert "\nno method reaches 1e-300; the best error is " in outcome.out


def test_simulation(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("mpmath")
    monkeypatch.setattr("robodyn.measure.accuracy.simulation.STEPS", (4e-3,))
    monkeypatch.setattr("robodyn.measure.accuracy.simulation.TOLERANCES", (1e-4,))
    few = tuple(method for method in METHODS if method.name in ("rk4", "verlet", "dop853"))
    monkeypatch.setattr("robodyn.measure.accuracy.simulation.METHODS", few)
    page = tmp_path / "front.html"
    printed = shown("accuracy", *PLANAR, "--duration", "0.02", "--report", str(page), "--target", "1e-5")
    assert "two_link_planar, 0.02 s: simulation, errors against gauss6 and dop853, which agree to" in printed
    assert f"\nwritten: {page}, " in printed
    text = page.read_text(encoding="utf-8")
    assert all(f'"label":"{label}"' in text for label in ("rk4", "dop853", "front", "target 1e-05"))
    assert [path.name for path in tmp_path.iterdir()] == ["front.html"]


@pytest.mark.slow
def test_a_simulation_as_accurate_as_asked() -> None:
    call = ("simulate", PLANAR[0], "--scene", PLANAR[1], "--duration", "0.1", "--accuracy", "1e-7")
    text = shown(*call)
    assert "\nnote: accuracy: 1e-07 asked, " in text
    found = json.loads(run(*call, "--format", "json").out)["accuracy"]
    assert found["target"] == 1e-7 >= found["expected"]
    refused(run(*call[:-3], "0.01", "--accuracy", "1e-18"), "an accuracy of 1e-18 cannot be promised: ")
    refused(run(*call, "--method", "rk4"), "--accuracy chooses method, step and tolerance")
