"""Places of findings in words, the short form, diffs applied by patch, lines about fixes, statistics."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest
from helpers.clean_arm import IDENTITY, arm
from helpers.command_line import run
from hypothesis import example, given
from hypothesis import strategies as st

from robodyn.checks.check import Checked, Options, check_one
from robodyn.checks.fixes import Fixed, fixed
from robodyn.checks.rule import Finding
from robodyn.report.check import check_diff, fix_lines, further, statistics_sections
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


PLANTED = arm(upper=IDENTITY, shoulder="0 2 0", elbow="0 2 0")


def repaired(data: bytes) -> Fixed:
    return fixed(data, "robots/arm.urdf", lambda changed: check_one(changed, name="robots/arm.urdf"))


def applied(diff: str, before: bytes, folder: Path) -> bytes:
    """What the program patch makes of a text."""
    path = folder / "arm.urdf"
    path.write_bytes(before)
    data = diff.encode("utf-8", "surrogateescape")
    subprocess.run(["patch", "--binary", "--silent", str(path)], input=data, check=True, capture_output=True)
    return path.read_bytes()


@pytest.mark.skipif(shutil.which("patch") is None, reason="there is no patch")
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("end", ["", "\n\n"])
def test_patch_makes_the_same(newline: str, end: str, tmp_path: Path) -> None:
    text = (PLANTED.rstrip("\n") + end).replace("<link", "<!-- ä\u2028\x85 -->\n<link", 1)
    result = repaired(text.replace("\n", newline).encode())
    assert result.after != result.before
    assert applied(check_diff(result), result.before, tmp_path) == result.after


@example(b"", b"\0")
@given(st.binary(max_size=30), st.binary(max_size=30))
def test_any_bytes(before: bytes, after: bytes) -> None:
    diff = check_diff(Fixed("a", before, after))
    assert (diff == "") == (before == after)
    assert not diff or diff.endswith("\n")


def test_a_line_for_each_fix() -> None:
    assert fix_lines([repaired(PLANTED.encode())], "fixed") == [
        "fixed: robots/arm.urdf:21: RD502, joint shoulder: divide the axis by its length "
        "(safe: the dynamics stay as they are)",
        "fixed: robots/arm.urdf:28: RD502, joint elbow: divide the axis by its length "
        "(safe: the dynamics stay as they are)",
    ]
    broken = PLANTED.replace('<child link="fore"/>', "").encode()
    assert [line.split(": ")[0] for line in fix_lines([repaired(broken)], "fixed")] == ["not fixed", "not fixed"]


def test_statistics() -> None:
    findings = [one for name in ("a", "b") for one in check_one(PLANTED.encode(), name=name)]
    findings += check_one(arm(upper=IDENTITY).encode(), name="a")
    head, *rows = text(statistics_sections(Checked(("a", "b"), tuple(findings)))).splitlines()
    assert head.split("  ")[0] == "rule"
    assert [row.split() for row in rows] == [
        ["RD502", "axis-length", "4", "4", "2", "4", "-"],
        ["RD208", "placeholder-tensor", "3", "3", "2", "-", "-"],
    ]
    assert text(statistics_sections(Checked((), ()))) == "no findings\n"
