"""The places of a finding in words, and the short form of a check."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from helpers.clean_arm import IDENTITY, arm
from helpers.command_line import run

from robodyn.checks.check import Options, Task, check_one, check_tasks
from robodyn.checks.rule import Finding
from robodyn.report.check import further, relative, short_sections
from robodyn.report.document import text

BOTH = arm(upper=IDENTITY, fore=IDENTITY, shoulder="0 2 0", elbow="0 0 0")
SHORT = """\
robots/both.urdf
  error RD501 zero-axis
    28:16: joint 'elbow': the axis is 0 0 0, which is no direction
  warning RD208 placeholder-tensor
    8:21: link 'upper': the inertia looks like a placeholder: the identity matrix, 1 kg m^2 three times
      also 15:21 link 'fore'
  warning RD502 axis-length
    21:16: joint 'shoulder': the axis has the length 2, not 1

2 files checked: 1 error, 2 warnings, 0 notes at 4 places: not fit for use as it is
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "both.urdf").write_text(BOTH)
    (tmp_path / "robots" / "clean.urdf").write_text(arm())
    return tmp_path


def places(amount: int, alike: bool) -> Finding:
    finding = check_one(BOTH.encode(), Options(("RD208",)))[0]
    message = finding.message
    others = (replace(finding, line=100 + k, message=message + f" {k}" * (not alike)) for k in range(amount - 1))
    return replace(finding, others=tuple(others))


def test_the_short_form_is_by_file_and_rule_the_most_severe_first(folder: Path) -> None:
    found = run("check", str(folder), "--format", "short")
    assert (found.status, found.out) == (1, SHORT)
    assert run("check", "robots", "--format", "short").out == SHORT


def test_the_short_form_says_how_much_is_not_shown(folder: Path) -> None:
    (folder / "robots" / "endless.urdf").write_text(arm().replace('effort="30"', 'effort="1e9"'))
    out = run("check", "robots", "--format", "short").out
    assert "\nnot shown: 1 minor finding of 1 rule (--select ALL)\n3 files checked: 1 error" in out


def test_the_long_form_lists_further_places() -> None:
    out = run("check", "robots/both.urdf").out
    assert "\n  also: 15:21 link 'fore'\n  do: write the inertia" in out
    assert out.index("RD208") < out.index("RD502") < out.index("RD501")


def test_what_is_hidden_is_counted_and_named_by_the_statistics(folder: Path) -> None:
    (folder / "both.urdf").write_text(BOTH.replace('"shoulder"', '"shoulder/1"').replace('"elbow"', '"elbow/1"'))
    flags = ("check", "both.urdf", "--ignore", "RD9")
    assert "\n\nnot shown: 1 minor finding of 1 rule (--select ALL)\n1 file checked: 1 error, " in run(*flags).out
    out = run(*flags, "--statistics").out
    assert [line.split() for line in out.splitlines()[-1:]] == [["RD110", "name-portability", "1", "2", "1", "-", "-"]]
    assert "\nNot shown, since they are minor; --select ALL shows them\n" in out
    assert "Not shown" not in run("check", "both.urdf", "--statistics", "--select", "ALL").out
    only = run("check", "robots/clean.urdf", "--statistics").out
    assert only == "no findings\n"


def test_few_places_are_listed_in_a_row_and_many_cut() -> None:
    assert further(places(1, True)) == []
    assert further(places(3, True)) == ["100:21 link 'upper', 101:21 link 'upper'"]
    assert further(places(3, False))[1].startswith("101:21 link 'upper': the inertia looks")
    row = " ".join(further(places(60, True)))
    assert (row.count("link"), row.endswith(", 19 more places")) == (40, True)
    lines = further(places(60, False))
    assert (len(lines), lines[-1]) == (11, "49 more places")
    assert all(len(line) <= 100 for line in further(places(60, True)))


def test_the_short_form_cuts_too() -> None:
    checked = check_tasks([Task("robots/both.urdf", Options(("RD208",)))])
    out = text(short_sections(replace(checked, findings=(places(60, False),))))
    assert "134" not in out
    assert ", 49 more places\n" in out


def test_relative_where_that_is_shorter(folder: Path) -> None:
    assert relative(str(folder / "robots" / "both.urdf")) == "robots/both.urdf"
    assert relative("/a.urdf") == "/a.urdf"
    assert relative("<stdin>") == "<stdin>"
