"""Robots that others publish: clean ones pass, and the defects of the others are found."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from helpers.example_robots import all_paths
from helpers.other_robots import other_paths
from helpers.robot_catalogue import FOLDER, names
from helpers.sampled import sampled
from pinned_findings import name_of

from robodyn.checks.check import check_one
from robodyn.checks.rule import Finding, Severity

CLEAN = ("go2", "g1_29dof_rev_1_0", "g1_29dof_with_hand_rev_1_0", "solo12", "xarm7", "kinova", "jvrc1")
PATHS = [*all_paths(), *other_paths()]


@cache
def found(path: Path) -> tuple[Finding, ...]:
    return check_one(str(path))


def named(stem: str) -> tuple[Finding, ...]:
    return found(next(path for path in PATHS if path.stem == stem))


def subjects(stem: str, code: str) -> set[str]:
    return {finding.subject.name for finding in named(stem) if finding.code == code and finding.subject}


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


def test_fingers_of_allegro_break_the_triangle_inequality() -> None:
    tips = {f"link_{k}.0" for k in (3, 7, 11, 15)}
    assert subjects("allegro_right_hand", "RD207") == subjects("allegro_left_hand", "RD207") == tips


def test_fingers_of_alex_mimic_joints_that_do_not_exist() -> None:
    assert len(subjects("alex_psyonic_hands", "RD510")) == 8


def test_tensors_of_romeo() -> None:
    assert subjects("romeo_laas_small", "RD206") == {"body", "LHipPitch_link", "RHipPitch_link"}
    assert subjects("romeo_laas_small", "RD207") == {"LShoulderYaw_link", "LElbowYaw_link"}
    assert subjects("romeo_small", "RD207") == {"RShoulderYawLink", "RElbowYawLink"}


def test_tensors_of_icub_are_those_of_points() -> None:
    points = subjects("icub", "RD204")
    assert {"r_ankle_1", "r_ankle_2", "r_lower_leg", "r_upper_leg"} <= points
    assert not subjects("icub", "RD206") | subjects("icub", "RD207")


def test_other_known_defects() -> None:
    assert {"base_antenna_left_link", "base_antenna_right_link"} <= subjects("tiago", "RD206")
    assert {"sensor_mount_link", "double_stereo_link"} == subjects("pr2", "RD207")
    assert len(subjects("iris", "RD504")) == 4
    assert len(subjects("hyq_no_sensors", "RD206")) == 5
    assert [finding.code for finding in named("ur3")] == ["RD107", "RD109"]


@pytest.mark.parametrize("name", names())
def test_our_robots_have_no_errors_but_those_that_they_waive(name: str) -> None:
    assert [finding for finding in found(FOLDER / f"{name}.urdf") if finding.severity is Severity.ERROR] == []
