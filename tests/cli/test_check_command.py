"""`robodyn check` and `robodyn rule`: exit status, forms of the report, options."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS, run
from helpers.planted_defects import HEALTHY

from robodyn.checks.catalogue import RULES

NEGATIVE = HEALTHY.replace('value="3.5"', 'value="-3.5"')
LONG_AXIS = HEALTHY.replace('xyz="0 0 1"', 'xyz="0 0 2"')
FINDING = ["file", "line", "column", "code", "name", "severity", "subject", "message", "remedy", "measured", "bound"]


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    path = tmp_path / "robot.urdf"
    path.write_text(HEALTHY)
    return path


@pytest.mark.parametrize(
    ("text", "flags", "status"),
    [
        (HEALTHY, (), 0),
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
    for form in ("text", "json"):
        outcome = run("check", str(robot), *flags, "--format", form)
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


def test_text_when_nothing_is_found(robot: Path) -> None:
    assert run("check", str(robot), "--select", "RD1").out == "1 file checked: nothing found\n"


def test_control_characters_never_reach_the_terminal(robot: Path) -> None:
    robot.write_bytes(NEGATIVE.replace('name="arm"', 'name="a\x7frm\u202e"').encode())
    out = run("check", str(robot)).out
    assert "\x7f" not in out
    assert "\u202e" not in out


def test_json_has_the_keys_of_the_contract(robot: Path) -> None:
    robot.write_text(NEGATIVE.replace('xyz="0 0 1"', 'xyz="0 0 2"'))
    document = json.loads(run("check", str(robot), "--select", "RD201,RD502", "--format", "json").out)
    assert document["summary"] == {"files": 1, "errors": 1, "warnings": 1, "notes": 0, "fit": False, "hidden": 0}
    mass, axis = document["findings"]
    assert list(mass) == [*FINDING, "cause", "fix", "places"]
    assert (mass["line"], mass["column"], mass["code"], mass["severity"]) == (15, 20, "RD201", "error")
    assert mass["subject"] == {"kind": "link", "name": "arm"}
    assert (mass["measured"], mass["bound"], mass["fix"]) == (-3.5, 0.0, None)
    (edit,) = axis["fix"]["edits"]
    assert axis["fix"]["safe"] is True
    assert robot.read_bytes()[edit["start"] : edit["end"]] == b"0 0 2"
    assert edit["text"] == "0.0 0.0 1.0"


def test_standard_input() -> None:
    outcome = run("check", "-", "--format", "json", stdin=NEGATIVE.encode())
    assert outcome.status == 1
    assert json.loads(outcome.out)["findings"][0]["file"] == "<stdin>"


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (("check",), "missing argument"),
        (("check", "absent.urdf"), "there is no such file"),
        (("check", str(ROBOTS), "--select", "RD999"), "there is no rule 'RD999'"),
        (("check", "-", "-"), "standard input is asked for twice"),
        (("rule", "RD999"), "no rule has the code or the word 'RD999' (RD9 means RD901 to RD902)"),
    ],
)
def test_wrong_calls_are_one_line_and_status_2(call: tuple[str, ...], error: str) -> None:
    outcome = run(*call)
    assert (outcome.status, outcome.out) == (2, "")
    assert error in outcome.err
    assert outcome.err.count("\n") == 1


def test_rule_by_code_and_by_name() -> None:
    assert run("rule", "RD207").out == run("rule", "rd207").out == run("rule", "triangle-inequality").out
    rule = next(rule for rule in RULES if rule.code == "RD207")
    out = run("rule", "RD207").out
    assert out.startswith("RD207 triangle-inequality (error: the check fails)\n")
    assert rule.summary in out
    assert all(line.strip() in out for line in (rule.bad + rule.good).splitlines())


def test_every_rule_and_the_list_of_them() -> None:
    everything, listing = run("rule", "--all").out, run("rule").out.splitlines()
    assert len(listing) == len(RULES)
    for rule, line in zip(RULES, listing, strict=True):
        assert f"{rule.code} {rule.name} (" in everything
        assert line.startswith(rule.code)
