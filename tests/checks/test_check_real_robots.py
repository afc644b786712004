"""Robots that others publish: clean ones pass, the defects of the others are found, and all of that was looked at.

`pinned_findings` says how to write the findings anew.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from benchmarks.audit_robots import CONDEMNS, errors_of
from benchmarks.witness import condemns, witness
from helpers.robot_catalogue import FOLDER, names
from helpers.sampled import sampled
from pinned_findings import counts, name_of, pinned, published

from robodyn.checks.check import Checked, check_one
from robodyn.checks.rule import Finding, Severity

CLEAN = ("go2", "g1_29dof_rev_1_0", "g1_29dof_with_hand_rev_1_0", "solo12", "xarm7", "kinova", "jvrc1")
KNOWN = {
    ("allegro_right_hand", "RD207"): {f"link_{k}.0" for k in (3, 7, 11, 15)},
    ("romeo_laas_small", "RD206"): {"body", "LHipPitch_link", "RHipPitch_link"},
    ("romeo_laas_small", "RD207"): {"LShoulderYaw_link", "LElbowYaw_link"},
    ("icub", "RD204"): {"r_ankle_1", "r_ankle_2", "r_lower_leg", "r_upper_leg"},
    ("pr2", "RD207"): {"sensor_mount_link", "double_stereo_link"},
    ("tiago", "RD206"): {"base_antenna_left_link", "base_antenna_right_link"},
}
PINNED = pinned()


@cache
def found(path: Path) -> tuple[Finding, ...]:
    return check_one(str(path))


@pytest.mark.parametrize("path", sampled(published(), 28), ids=name_of)
def test_the_same_findings_at_places_that_are_there(path: Path) -> None:
    assert counts(found(path)) == PINNED[name_of(path)]
    for finding in found(path):
        assert finding.file == str(path) or finding.file.endswith(".srdf")
        lines = Path(finding.file).read_text(encoding="utf-8").split("\n")
        line = lines[finding.line - 1]
        assert 1 <= finding.column <= len(line) + 1
        start = line[finding.column - 1 :].replace("\t", " ")
        assert start.startswith(finding.excerpt.text[finding.excerpt.start :].rstrip()[:20])


def test_the_same_robots_and_clean_ones_without_errors() -> None:
    assert set(PINNED) == {name_of(path) for path in published()}
    pinned_codes = {path.stem: " ".join(PINNED[name_of(path)]) for path in published()}
    assert not [stem for stem in CLEAN if "ERROR" in pinned_codes[stem]]
    assert pinned_codes["ur3"].split()[::2] == ["RD107", "RD109"]


@pytest.mark.parametrize(("stem", "code"), sampled([pytest.param(*each, id="-".join(each)) for each in KNOWN], 6))
def test_known_defects(stem: str, code: str) -> None:
    one = found(next(path for path in published() if path.stem == stem))
    subjects = {finding.subject.name for finding in one if finding.code == code and finding.subject}
    assert KNOWN[stem, code] <= subjects
    assert code == "RD204" or stem == "tiago" or KNOWN[stem, code] == subjects


@pytest.mark.parametrize("name", sampled(names(), 3))
def test_our_robots_have_no_errors_but_those_that_they_waive(name: str) -> None:
    assert [finding for finding in found(FOLDER / f"{name}.urdf") if finding.severity is Severity.ERROR] == []


ACCUSED = [
    path for path in published() if any(key.endswith("ERROR") and key[:5] in CONDEMNS for key in PINNED[name_of(path)])
]


@pytest.mark.parametrize("path", sampled(ACCUSED, 15), ids=name_of)
def test_every_error_has_a_witness(path: Path, tmp_path: Path) -> None:
    folder = next(up for up in path.parents if up.name in ("example-robot-data", "iCub", "share"))
    errors = [*errors_of("", folder, Checked((str(path),), found(path)), tmp_path)]
    assert errors
    assert not [error for error in errors if not condemns(error, witness(error))]
