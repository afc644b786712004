"""Of many files one that fails stops no other: it is told by a line, in the data and by the exit status."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from helpers.clean_arm import arm
from helpers.command_line import ROBOTS, refused, run
from helpers.schemas import JUNIT, SARIF, json_schema
from jsonschema import Draft7Validator
from lxml import etree

GOOD = ("bracket.stl", "cross.stl")
THREE = ("bracket.stl", "open_tray.stl", "none.stl", "cross.stl")
MANY = ("axis.urdf", "none.urdf", "clean.urdf", "--select", "RD502")
GONE = "there is no such file (check the name)"
LINE = f"error: none.urdf: {GONE}\n"


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in (*GOOD, "open_tray.stl"):
        shutil.copy(ROBOTS / "meshes" / name, name)
    Path("clean.urdf").write_text(arm())
    Path("axis.urdf").write_text(arm(shoulder="0 2 0"))


def test_an_open_mesh_stops_no_other() -> None:
    """Its place is kept among the elements, and it is an entry in the data."""
    outcome = run("inertia", *THREE)
    assert (outcome.status, outcome.out) == (2, run("inertia", *GOOD).out)
    outcome = run("inertia", *THREE, "--format", "json")
    assert outcome.status == 2
    entries = json.loads(outcome.out)["meshes"]
    sound = json.loads(run("inertia", *GOOD, "--format", "json").out)["meshes"]
    assert [entries[0], entries[3]] == sound
    assert [entry["name"] for entry in entries] == list(THREE)
    assert entries[1]["error"].startswith("the surface is not closed")
    first, second = outcome.err.splitlines()
    assert first == f"error: open_tray.stl: {entries[1]['error']}"
    assert second.startswith("error: none.stl: ")
    outcome = run("inertia", *THREE, "--format", "urdf")
    assert (outcome.status, len(outcome.err.splitlines())) == (2, 2)
    root = etree.fromstring(f"<all>{outcome.out}</all>")
    kinds = [child.tag if isinstance(child.tag, str) else child.text.split(":")[0].strip() for child in root]
    assert kinds == ["inertial", "open_tray.stl", "none.stl", "inertial"]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (("inertia", *THREE), ["2 of 4 meshes failed", "open_tray.stl: the surface is not closed", "none.stl"]),
        (("check", "axis.urdf", "none.urdf"), ["1 file could not be read", "none.urdf: there is no such file"]),
    ],
)
def test_failures_are_on_the_page(call: tuple[str, ...], words: list[str]) -> None:
    assert run(*call, "--report", "r.md").status == 2
    text = Path("r.md").read_text().replace("\\_", "_")
    assert [each for each in words if each not in text] == []


def test_meshes_that_all_fail_or_are_one_body() -> None:
    for call in (("open_tray.stl", "none.stl", "--report", "r.html"), (*THREE, "--combine")):
        outcome = run("inertia", *call)
        assert (outcome.status, outcome.out) == (2, "")
        assert [line.split(":")[1] for line in outcome.err.splitlines()] == [" open_tray.stl", " none.stl"]
    assert not Path("r.html").exists()
    for call in (("open_tray.stl", "--format", "json"), (*GOOD, "--density", "-1")):
        refused(run("inertia", *call), "")


@pytest.mark.parametrize("apart", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_file_that_cannot_be_read_stops_no_check(apart: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor where processes work."""
    monkeypatch.setattr("robodyn.checks.check.worth_processes", lambda files: apart)
    outcome = run("check", *MANY)
    assert (outcome.status, outcome.err) == (2, LINE)
    assert outcome.out.startswith("axis.urdf:")
    assert outcome.out.endswith("2 files checked: 0 errors, 1 warning, 0 notes; 1 file could not be read\n")


def test_a_file_that_cannot_be_read_is_in_the_data() -> None:
    document = json.loads(run("check", *MANY, "--format", "json").out)
    assert document["unread"] == [{"file": "none.urdf", "error": GONE}]
    assert document["summary"]["files"] == 2
    junit = etree.fromstring(run("check", *MANY, "--format", "junit").out.encode())
    etree.XMLSchema(etree.fromstring(JUNIT)).assertValid(junit)
    assert (junit.get("errors"), junit.get("tests")) == ("1", "3")
    assert [error.get("message") for error in junit.iter("error")] == [GONE]
    sarif = json.loads(run("check", *MANY, "--format", "sarif").out)
    Draft7Validator(json_schema(SARIF)).validate(sarif)
    (invocation,) = sarif["runs"][0]["invocations"]
    assert invocation["executionSuccessful"] is False
    assert [each["message"]["text"] for each in invocation["toolExecutionNotifications"]] == [GONE]
    github = run("check", *MANY, "--format", "github").out
    assert github.splitlines()[-1] == f"::error file=none.urdf::{GONE}"


@pytest.mark.parametrize("how", ["--fix", "--diff"])
def test_the_others_are_fixed(how: str) -> None:
    outcome = run("check", *MANY, how)
    assert (outcome.status, outcome.err.count(LINE)) == (2, 1)
    assert ("0.0 1.0 0.0" in Path("axis.urdf").read_text()) == (how == "--fix")
    assert ("+    <axis" in outcome.out) == (how == "--diff")


def test_one_file_alone_is_one_line() -> None:
    """Servers, which read one of the forms made for them, are told of it there too."""
    for form, told in {"text": 0, "json": 0, "sarif": 1, "junit": 1, "github": 1}.items():
        outcome = run("check", "none.urdf", "--format", form)
        assert (outcome.status, outcome.err) == (2, LINE)
        assert outcome.out.count("there is no such file") == told
