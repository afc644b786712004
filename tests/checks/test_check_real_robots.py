"""Robots that others publish: clean ones pass, the defects of the others are found, and all of that was looked at.

`pinned_findings` says how to write the findings anew.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from helpers.example_robots import all_paths
from helpers.other_robots import other_paths
from helpers.robot_catalogue import FOLDER, names
from helpers.sampled import sampled
from pinned_findings import counts, name_of, pinned, published

from robodyn.checks.check import check_one
from robodyn.checks.rule import Finding, Severity

CLEAN = ("go2", "g1_29dof_rev_1_0", "g1_29dof_with_hand_rev_1_0", "solo12", "xarm7", "kinova", "jvrc1")
PATHS = [*all_paths(), *other_paths()]


@cache
def found(path: Path) -> tuple[Finding, ...]:
    return check_one(str(path))


def named(stem: str) -> tuple[Finding, ...]:
    return found(next(path for path in PATHS if path.stem == stem))


@pytest.mark.parametrize("path", sampled(PATHS, 16), ids=name_of)
def test_every_file_is_read_and_each_finding_has_a_place(path: Path) -> None:
    for finding in found(path):
        assert finding.file == str(path) or finding.file.endswith(".srdf")
        lines = Path(finding.file).read_text(encoding="utf-8").split("\n")
        line = lines[finding.line - 1]
        assert 1 <= finding.column <= len(line) + 1
        start = line[finding.column - 1 :].replace("\t", " ")
        assert start.startswith(finding.excerpt.text[finding.excerpt.start :].rstrip()[:20])


@pytest.mark.parametrize("stem", CLEAN)
def test_clean_robots_have_no_errors(stem: str) -> None:
    assert [finding for finding in named(stem) if finding.severity is Severity.ERROR] == []


KNOWN = {
    ("allegro_right_hand", "RD207"): {f"link_{k}.0" for k in (3, 7, 11, 15)},
    ("allegro_left_hand", "RD207"): {f"link_{k}.0" for k in (3, 7, 11, 15)},
    ("romeo_laas_small", "RD206"): {"body", "LHipPitch_link", "RHipPitch_link"},
    ("romeo_laas_small", "RD207"): {"LShoulderYaw_link", "LElbowYaw_link"},
    ("romeo_small", "RD207"): {"RShoulderYawLink", "RElbowYawLink"},
    ("icub", "RD206"): set(),
    ("icub", "RD207"): set(),
    ("pr2", "RD207"): {"sensor_mount_link", "double_stereo_link"},
}


def test_known_defects() -> None:
    subjects: dict[tuple[str, str], set[str]] = {}
    for stem in ("tiago", "alex_psyonic_hands", "iris", "hyq_no_sensors", *(stem for stem, _ in KNOWN)):
        for finding in named(stem):
            subjects.setdefault((stem, finding.code), set()).add(finding.subject.name if finding.subject else "")
    assert {key: subjects.get(key, set()) for key in KNOWN} == KNOWN
    assert {"r_ankle_1", "r_ankle_2", "r_lower_leg", "r_upper_leg"} <= subjects["icub", "RD204"], "tensors of points"
    assert {"base_antenna_left_link", "base_antenna_right_link"} <= subjects["tiago", "RD206"]
    counted = (("alex_psyonic_hands", "RD510"), ("iris", "RD504"), ("hyq_no_sensors", "RD206"))
    assert [len(subjects[key]) for key in counted] == [8, 4, 5]
    assert [finding.code for finding in named("ur3")] == ["RD107", "RD109"]


@pytest.mark.parametrize("name", names())
def test_our_robots_have_no_errors_but_those_that_they_waive(name: str) -> None:
    assert [finding for finding in found(FOLDER / f"{name}.urdf") if finding.severity is Severity.ERROR] == []


PINNED = pinned()


def test_the_same_robots() -> None:
    assert set(PINNED) == {name_of(path) for path in published()}


@pytest.mark.parametrize("path", sampled(published(), 6), ids=name_of)
def test_the_same_findings(path: Path) -> None:
    assert counts(path) == PINNED[name_of(path)]
