"""The diff, applied by patch, and the lines about fixes; statistics."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from helpers.clean_arm import IDENTITY, arm
from hypothesis import example, given
from hypothesis import strategies as st

from robodyn.checks.check import Checked, check_one
from robodyn.checks.fixes import Fixed, fixed
from robodyn.report.check import check_diff, fix_lines, statistics_sections
from robodyn.report.document import text

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


def test_a_diff_of_one_line() -> None:
    diff = check_diff(repaired(arm(shoulder="0 2 0").encode())).splitlines()
    assert diff[:2] == ["--- robots/arm.urdf", "+++ robots/arm.urdf"]
    assert [line for line in diff[2:] if line[0] in "+-"] == [
        '-    <axis xyz="0 2 0"/>',
        '+    <axis xyz="0.0 1.0 0.0"/>',
    ]


def test_no_change_no_diff() -> None:
    assert check_diff(repaired(arm().encode())) == ""


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
