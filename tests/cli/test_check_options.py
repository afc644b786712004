"""Options of `robodyn check` beyond the rules: forms, settings, baseline, fixes, expanded files."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.clean_arm import FAMILIES, IDENTITY, arm
from helpers.command_line import run
from helpers.schemas import JUNIT, SARIF, json_schema
from jsonschema import Draft7Validator
from lxml import etree

AXIS = arm(shoulder="0 2 0")
BOTH = arm(upper=IDENTITY, shoulder="0 2 0")
ERROR = arm(shoulder="0 0 0", elbow="0 2 0")
OLD = ",".join(FAMILIES)
EDIT = '-    <axis xyz="0 2 0"/>\n+    <axis xyz="0.0 1.0 0.0"/>\n'


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, text in (("clean", arm()), ("axis", AXIS), ("both", BOTH), ("error", ERROR)):
        (tmp_path / f"{name}.urdf").write_text(text)
    return tmp_path


def test_sarif() -> None:
    outcome = run("check", ".", "--format", "sarif")
    assert (outcome.status, outcome.err) == (1, "")
    document = json.loads(outcome.out)
    Draft7Validator(json_schema(SARIF)).validate(document)
    assert [result["ruleId"] for result in document["runs"][0]["results"]].count("RD502") == 3
    piped = json.loads(run("check", "-", "--format", "sarif", stdin=AXIS.encode()).out)
    assert piped["runs"][0]["results"][0]["fixes"]


def test_junit() -> None:
    for strict, failures in (((), "1"), (("--strict",), "5")):
        outcome = run("check", ".", "--select", OLD, "--format", "junit", *strict)
        document = etree.fromstring(outcome.out.encode())
        etree.XMLSchema(etree.fromstring(JUNIT)).assertValid(document)
        assert (outcome.status, document.get("failures"), document.get("tests")) == (1, failures, "6")


def test_github() -> None:
    outcome = run("check", "clean.urdf", "both.urdf", "--format", "github", "--strict")
    assert (outcome.status, outcome.err) == (1, "")
    assert [line.split(" ")[0] for line in outcome.out.splitlines()] == ["::warning", "::warning"]


def test_statistics() -> None:
    outcome = run("check", ".", "--select", OLD, "--statistics")
    assert outcome.status == 1
    assert [row.split()[:3] for row in outcome.out.splitlines()[1:]] == [
        ["RD502", "axis-length", "3"],
        ["RD208", "placeholder-tensor", "1"],
        ["RD501", "zero-axis", "1"],
    ]


def test_settings(folder: Path) -> None:
    (folder / "pyproject.toml").write_text('[tool.robodyn.check.per-file-ignores]\n"both.*" = ["RD208"]\n')
    assert run("check", "both.urdf", "axis.urdf", "--strict", "--ignore", "RD502").status == 0
    (folder / "other.toml").write_text('[tool.robodyn.check]\nignore = ["RD5"]\n')
    assert run("check", "both.urdf", "--strict", "--config", "other.toml", "--select", "RD5").status == 0
    assert "RD208" in run("check", "both.urdf", "--strict", "--config", "other.toml").out


def test_package_path_is_handed_on(folder: Path) -> None:
    for name in ("a", "b"):
        (folder / name).mkdir()
    assert run("check", "clean.urdf", "--package-path", "a", "--package-path", "b").status == 0


def test_baseline(folder: Path) -> None:
    written = run("check", "error.urdf", "both.urdf", "--select", OLD, "--baseline", "known.json", "--write-baseline")
    assert (written.status, written.out, written.err) == (0, "", "written: known.json, 4 places\n")
    again = run("check", "error.urdf", "both.urdf", "--select", OLD, "--baseline", "known.json", "--strict")
    assert (again.status, again.err) == (0, "known.json: 4 places passed over\n")
    assert again.out == "2 files checked: nothing found\n"
    (folder / "error.urdf").write_text("\n\n" + arm(shoulder="0 1 0", elbow="0 0 0")[22:])
    new = run("check", "error.urdf", "both.urdf", "--select", OLD, "--baseline", "known.json", "--format", "json")
    assert new.status == 1
    assert [finding["subject"]["name"] for finding in json.loads(new.out)["findings"]] == ["elbow"]
    assert new.err == "known.json: 2 places passed over; 2 of it no longer found, --write-baseline drops them\n"


def test_fix(folder: Path) -> None:
    outcome = run("check", "both.urdf", "clean.urdf", "--fix")
    assert outcome.status == 0
    assert outcome.err == (
        "fixed: both.urdf:21: RD502, joint shoulder: divide the axis by its length "
        "(safe: the dynamics stay as they are)\n"
    )
    assert "RD208" in outcome.out
    assert "RD502" not in outcome.out
    assert (folder / "both.urdf").read_text() == BOTH.replace("0 2 0", "0.0 1.0 0.0")
    assert (folder / "clean.urdf").read_text() == arm()
    again = run("check", "both.urdf", "--fix")
    assert (again.status, again.err) == (0, "")
    assert sorted(path.name for path in folder.iterdir()) == ["axis.urdf", "both.urdf", "clean.urdf", "error.urdf"]


def test_what_cannot_be_proven_stays(folder: Path) -> None:
    outcome = run("check", "error.urdf", "--fix")
    assert outcome.status == 1
    assert outcome.err.startswith(
        "not fixed: error.urdf:28: RD502, joint elbow: divide the axis by its length (the dyn"
    )
    assert (folder / "error.urdf").read_text() == ERROR


def test_diff(folder: Path) -> None:
    outcome = run("check", "clean.urdf", "axis.urdf", "both.urdf", "--diff")
    assert outcome.status == 1
    assert outcome.out.count(EDIT) == 2
    assert outcome.out.startswith("--- axis.urdf\n+++ axis.urdf\n@@ ")
    assert outcome.err.count("would fix: ") == 2
    assert (folder / "axis.urdf").read_text() == AXIS
    assert run("check", "clean.urdf", "--diff").status == 0
    assert run("check", "error.urdf", "--diff", "--select", "RD501").status == 1
    assert EDIT in run("check", "-", "--diff", stdin=AXIS.encode()).out
    assert run("check", "axis.urdf", "--diff", "--fix").out.count(EDIT) == 1
    assert (folder / "axis.urdf").read_text() == AXIS


def test_unsafe_fixes(folder: Path) -> None:
    lower = BOTH.replace(IDENTITY, '<inertia ixx="0.01" iyx="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/>')
    (folder / "lower.urdf").write_text(lower)
    assert "iyx" not in run("check", "lower.urdf", "--diff").out.replace('<inertia ixx="0.01" iyx="0"', "")
    outcome = run("check", "lower.urdf", "--fix", "--unsafe-fixes")
    assert outcome.status == 0
    assert "RD006, link upper: call it ixy (unsafe: " in outcome.err
    assert (folder / "lower.urdf").read_text() == lower.replace("iyx", "ixy").replace("0 2 0", "0.0 1.0 0.0")


def test_a_file_that_cannot_be_written(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    outcome = run("check", "axis.urdf", "--fix")
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == "error: axis.urdf: cannot be written: no space left on device (nothing was written)\n"
    assert (folder / "axis.urdf").read_text() == AXIS


def test_expanded_files(folder: Path) -> None:
    (folder / "arm.xacro").write_text(BOTH.replace("<robot", '<robot xmlns:xacro="http://ros.org/wiki/xacro"'))
    outcome = run("check", "arm.xacro", "--format", "junit")
    assert outcome.status == 0
    assert outcome.err == ""
    assert '<testsuite name="arm.xacro" tests="2"' in outcome.out
    sarif = json.loads(run("check", "arm.xacro", "--format", "sarif").out)
    Draft7Validator(json_schema(SARIF)).validate(sarif)
    assert run("check", ".", "--format", "json").out.count("arm.xacro") == 0


@pytest.mark.parametrize(
    ("flags", "error"),
    [
        (("clean.urdf", "--write-baseline"), "--write-baseline needs --baseline FILE (try: robodyn check --help)"),
        (("clean.urdf", "--baseline", "no.json"), "no.json: there is no such baseline (write it with"),
        (("clean.urdf", "--baseline", "clean.urdf"), "clean.urdf: this is no baseline (write it anew with"),
        (("clean.urdf", "--unsafe-fixes"), "--unsafe-fixes needs --fix or --diff (try: robodyn check --help)"),
        (("-", "--fix"), "--fix cannot edit standard input; --diff shows the edit (try: robodyn check --help)"),
        (("clean.urdf", "--statistics", "--format", "json"), "--statistics is text; leave --format out (try: "),
        (("clean.urdf", "--config", "no.toml"), "no.toml: cannot be read: no such file or directory"),
        (("clean.urdf", "--config", "clean.urdf"), "clean.urdf:1: is not TOML: "),
        (
            ("clean.urdf", "--format", "xml"),
            "invalid value for '--format': 'xml' is not one of 'text', 'short', 'json'",
        ),
        (("no.xacro",), "no.xacro: there is no such file (check the name)"),
    ],
)
def test_wrong_calls_are_one_line_and_status_2(flags: tuple[str, ...], error: str) -> None:
    outcome = run("check", *flags)
    assert (outcome.status, outcome.out, outcome.err.count("\n")) == (2, "", 1)
    assert outcome.err.startswith(f"error: {error}")


def test_a_mistake_in_the_settings_names_the_file(folder: Path) -> None:
    (folder / "robodyn.toml").write_text("[tool.robodyn.check]\nfix = true\n")
    outcome = run("check", "clean.urdf")
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith(
        f'error: {folder}/robodyn.toml:2: [tool.robodyn.check]: unknown key "fix" (valid keys: '
    )
