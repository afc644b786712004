"""`robodyn check` and `robodyn rule`: exit status, forms of the report, options."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.clean_arm import FAMILIES, IDENTITY, arm
from helpers.command_line import run
from helpers.planted_defects import HEALTHY

from robodyn.checks.catalogue import RULES

NEGATIVE = HEALTHY.replace('value="3.5"', 'value="-3.5"')
LONG_AXIS = HEALTHY.replace('xyz="0 0 1"', 'xyz="0 0 2"')
AXIS = arm(shoulder="0 2 0")
BOTH = arm(upper=IDENTITY, shoulder="0 2 0")
ERROR = arm(shoulder="0 0 0", elbow="0 2 0")
OLD = ",".join(FAMILIES)
EDIT = '-    <axis xyz="0 2 0"/>\n+    <axis xyz="0.0 1.0 0.0"/>\n'


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    path = tmp_path / "robot.urdf"
    path.write_text(HEALTHY)
    return path


@pytest.mark.parametrize(
    ("text", "flags", "status"),
    [
        (HEALTHY, ("--strict",), 0),
        (LONG_AXIS, (), 0),
        (LONG_AXIS, ("--strict",), 1),
        (LONG_AXIS, ("--strict", "--ignore", "RD502"), 0),
        (NEGATIVE, (), 1),
        (NEGATIVE, ("--ignore", "rd201,RD5"), 0),
        (NEGATIVE, ("--select", "RD1"), 0),
        ("<robot", (), 1),
    ],
)
def test_exit_status(robot: Path, text: str, flags: tuple[str, ...], status: int) -> None:
    robot.write_text(text)
    outcome = run("check", str(robot), *flags)
    assert (outcome.status, outcome.err) == (status, "")


def test_text_has_the_line_and_a_caret_below_the_value(robot: Path) -> None:
    robot.write_text(NEGATIVE)
    lines = run("check", str(robot), "--select", "RD201").out.splitlines()
    assert lines[0] == f"{robot}:15:20: error RD201 mass-not-positive: link 'arm': the mass is -3.5 kg, not positive"
    assert lines[1] == '  15 | <mass value="-3.5"/>'
    assert lines[2].index("^") == lines[1].index("-3.5")
    assert lines[2].count("^") == len("-3.5")
    assert lines[3].startswith("  do: write the mass")
    assert lines[-1] == "1 file checked: 1 error, 0 warnings, 0 notes: not fit for use as it is"


def test_json(robot: Path) -> None:
    robot.write_text(NEGATIVE.replace('xyz="0 0 1"', 'xyz="0 0 2"'))
    document = json.loads(run("check", str(robot), "--select", "RD201,RD502", "--format", "json").out)
    assert document["summary"] == {"files": 1, "errors": 1, "warnings": 1, "notes": 0, "fit": False, "hidden": 0}
    mass, axis = document["findings"]
    assert (mass["line"], mass["column"], mass["code"], mass["severity"]) == (15, 20, "RD201", "error")
    assert mass["subject"] == {"kind": "link", "name": "arm"}
    assert (mass["measured"], mass["bound"], mass["fix"]) == (-3.5, 0.0, None)
    (edit,) = axis["fix"]["edits"]
    assert axis["fix"]["safe"] is True
    assert robot.read_bytes()[edit["start"] : edit["end"]] == b"0 0 2"
    assert edit["text"] == "0.0 0.0 1.0"


def test_further_formats_of_the_same_run(robot: Path) -> None:
    """Each as it is alone."""
    robot.write_text(NEGATIVE)
    files = {
        form: robot.with_name(f"findings.{form}") for form in ("json", "sarif", "junit", "github", "short", "text")
    }
    also = [word for form, file in files.items() for word in ("--also", f"{form}={file}")]
    assert run("check", str(robot), "--strict", *also).status == 1
    for form, file in files.items():
        assert file.read_text() == run("check", str(robot), "--strict", "--format", form).out, form
    for wrong in ("sarf=x", "sarif", "sarif="):
        outcome = run("check", str(robot), "--also", wrong)
        assert (outcome.status, outcome.err.count("\n")) == (2, 1)
        assert f"{wrong!r} is not FORMAT=FILE; formats are text, short, json" in outcome.err


def test_rules_are_explained_and_listed() -> None:
    assert run("rule", "RD207").out == run("rule", "rd207").out == run("rule", "Triangle-Inequality").out
    rule = next(rule for rule in RULES if rule.code == "RD207")
    out = run("rule", "RD207").out
    assert out.startswith("RD207 triangle-inequality (error: the check fails)\n")
    assert all(line.strip() in out for line in (rule.summary, *(rule.bad + rule.good).splitlines()))
    everything, listing = run("rule", "--all").out, run("rule").out.splitlines()
    for rule, line in zip(RULES, listing, strict=True):
        assert f"{rule.code} {rule.name} (" in everything
        assert line.startswith(rule.code)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, text in (("clean", arm()), ("axis", AXIS), ("both", BOTH), ("error", ERROR)):
        (tmp_path / f"{name}.urdf").write_text(text)
    return tmp_path


def test_settings(folder: Path) -> None:
    (folder / "pyproject.toml").write_text('[tool.robodyn.check.per-file-ignores]\n"both.*" = ["RD208"]\n')
    assert run("check", "both.urdf", "axis.urdf", "--strict", "--ignore", "RD502").status == 0
    (folder / "other.toml").write_text('[tool.robodyn.check]\nignore = ["RD5"]\n')
    assert run("check", "both.urdf", "--strict", "--config", "other.toml", "--select", "RD5").status == 0
    assert "RD208" in run("check", "both.urdf", "--strict", "--config", "other.toml").out


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
