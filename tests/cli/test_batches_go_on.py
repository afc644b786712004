"""Of many files one that fails stops no other: it is told by a line, in the data and by the exit status."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from helpers.clean_arm import arm
from helpers.command_line import ROBOTS, run
from helpers.schemas import JUNIT, SARIF, json_schema
from jsonschema import Draft7Validator
from lxml import etree

MESHES = ROBOTS / "meshes"
GOOD = ("bracket.stl", "cross.stl")
OPEN = "error: open_tray.stl: the surface is not closed"


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in (*GOOD, "open_tray.stl"):
        shutil.copy(MESHES / name, name)
    Path("clean.urdf").write_text(arm())
    Path("axis.urdf").write_text(arm(shoulder="0 2 0"))


THREE = ("bracket.stl", "open_tray.stl", "none.stl", "cross.stl")


def test_an_open_mesh_stops_no_other() -> None:
    outcome = run("inertia", *THREE)
    assert outcome.status == 2
    assert outcome.out == run("inertia", *GOOD).out
    first, second = outcome.err.splitlines()
    assert first.startswith(OPEN)
    assert second.startswith("error: none.stl: ")


def test_an_open_mesh_is_an_entry_in_the_data() -> None:
    outcome = run("inertia", *THREE, "--format", "json")
    assert outcome.status == 2
    entries = json.loads(outcome.out)["meshes"]
    sound = json.loads(run("inertia", *GOOD, "--format", "json").out)["meshes"]
    assert [entries[0], entries[3]] == sound
    assert [entry["name"] for entry in entries] == list(THREE)
    assert [entry.keys() for entry in entries[1:3]] == [{"name", "error"}] * 2
    assert entries[1]["error"].startswith("the surface is not closed")
    assert f"error: open_tray.stl: {entries[1]['error']}" in outcome.err.splitlines()


def test_an_open_mesh_keeps_its_place_among_elements() -> None:
    outcome = run("inertia", *THREE, "--format", "urdf")
    assert outcome.status == 2
    assert len(outcome.err.splitlines()) == 2
    root = etree.fromstring(f"<all>{outcome.out}</all>")
    kinds = [child.tag if isinstance(child.tag, str) else child.text.split(":")[0].strip() for child in root]
    assert kinds == ["inertial", "open_tray.stl", "none.stl", "inertial"]


@pytest.mark.parametrize("name", ["r.html", "r.md"])
def test_an_open_mesh_is_on_the_page(name: str) -> None:
    outcome = run("inertia", *THREE, "--report", name)
    assert outcome.status == 2
    text = Path(name).read_text().replace("\\_", "_")
    assert "2 of 4 meshes failed" in text
    assert "open_tray.stl: the surface is not closed" in text
    assert "none.stl" in text


@pytest.mark.parametrize("form", ["text", "json", "urdf"])
def test_one_mesh_alone_is_one_line(form: str) -> None:
    outcome = run("inertia", "open_tray.stl", "--format", form)
    assert (outcome.status, outcome.out) == (2, "")
    assert len(outcome.err.splitlines()) == 1


def test_combined_meshes_are_all_named_that_fail() -> None:
    outcome = run("inertia", *THREE, "--combine")
    assert (outcome.status, outcome.out) == (2, "")
    assert [line.split(":")[1] for line in outcome.err.splitlines()] == [" open_tray.stl", " none.stl"]


def test_all_meshes_fail() -> None:
    outcome = run("inertia", "open_tray.stl", "none.stl", "--report", "r.html")
    assert (outcome.status, outcome.out) == (2, "")
    assert len(outcome.err.splitlines()) == 2
    assert not Path("r.html").exists()
    assert len(json.loads(run("inertia", "open_tray.stl", "none.stl", "--format", "json").out)["meshes"]) == 2


def test_a_wrong_option_is_said_once() -> None:
    outcome = run("inertia", *GOOD, "--density", "-1")
    assert (outcome.status, outcome.out, len(outcome.err.splitlines())) == (2, "", 1)


MANY = ("axis.urdf", "none.urdf", "clean.urdf")
LINE = "error: none.urdf: there is no such file (check the name)\n"


def test_a_file_that_cannot_be_read_stops_no_check() -> None:
    outcome = run("check", *MANY, "--select", "RD502")
    assert (outcome.status, outcome.err) == (2, LINE)
    assert outcome.out.startswith("axis.urdf:")
    assert outcome.out.endswith("2 files checked: 0 errors, 1 warning, 0 notes; 1 file could not be read\n")
    clean = run("check", "clean.urdf", "none.urdf", "--select", "RD502")
    assert clean.out == "1 file checked: nothing found; 1 file could not be read\n"


def test_a_file_that_cannot_be_read_is_in_the_data() -> None:
    document = json.loads(run("check", *MANY, "--format", "json").out)
    assert document["unread"] == [{"file": "none.urdf", "error": "there is no such file (check the name)"}]
    assert document["summary"]["files"] == 2
    assert json.loads(run("check", "clean.urdf", "--format", "json").out)["unread"] == []


def test_a_file_that_cannot_be_read_is_an_error_of_junit() -> None:
    document = etree.fromstring(run("check", *MANY, "--format", "junit", "--select", "RD502").out.encode())
    etree.XMLSchema(etree.fromstring(JUNIT)).assertValid(document)
    assert (document.get("errors"), document.get("tests")) == ("1", "3")
    (error,) = document.iter("error")
    assert error.get("message") == "there is no such file (check the name)"


def test_a_file_that_cannot_be_read_is_a_notification_of_sarif() -> None:
    document = json.loads(run("check", *MANY, "--format", "sarif").out)
    Draft7Validator(json_schema(SARIF)).validate(document)
    (invocation,) = document["runs"][0]["invocations"]
    assert invocation["executionSuccessful"] is False
    (notification,) = invocation["toolExecutionNotifications"]
    assert notification["message"]["text"] == "there is no such file (check the name)"
    (invocation,) = json.loads(run("check", "clean.urdf", "--format", "sarif").out)["runs"][0]["invocations"]
    assert invocation == {"executionSuccessful": True}


def test_a_file_that_cannot_be_read_is_said_to_github() -> None:
    outcome = run("check", *MANY, "--format", "github", "--select", "RD502")
    assert outcome.out.splitlines()[-1] == "::error file=none.urdf::there is no such file (check the name)"


@pytest.mark.parametrize("name", ["r.html", "r.md"])
def test_a_file_that_cannot_be_read_is_on_the_page(name: str) -> None:
    run("check", *MANY, "--report", name)
    text = Path(name).read_text()
    assert "1 file could not be read" in text
    assert "none.urdf: there is no such file" in text


def test_processes_do_not_stop_either(monkeypatch: pytest.MonkeyPatch) -> None:
    from robodyn.checks import check as checks

    monkeypatch.setattr(checks, "worth_processes", lambda files: True)
    outcome = run("check", *MANY, "--select", "RD502")
    assert (outcome.status, outcome.err) == (2, LINE)


@pytest.mark.parametrize("how", ["--fix", "--diff"])
def test_the_others_are_fixed(how: str) -> None:
    outcome = run("check", *MANY, how, "--select", "RD502")
    assert outcome.status == 2
    assert outcome.err.count(LINE) == 1
    assert ("0.0 1.0 0.0" in Path("axis.urdf").read_text()) == (how == "--fix")
    assert ("+    <axis" in outcome.out) == (how == "--diff")


def test_one_file_alone_is_one_line() -> None:
    """Servers, which read one of the forms made for them, are told of it there too."""
    for form, told in {"text": 0, "json": 0, "sarif": 1, "junit": 1, "github": 1}.items():
        outcome = run("check", "none.urdf", "--format", form)
        assert (outcome.status, outcome.err) == (2, LINE)
        assert outcome.out.count("there is no such file") == told
