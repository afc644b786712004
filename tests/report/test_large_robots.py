"""Reports on robots with many joints: offenders first, none dropped, every name told from the others."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

import pytest
from helpers.html_pages import Page, checked
from helpers.oracles import ROBOTS, robot
from helpers.report_text import torques_text

import robodyn
from robodyn.loads.result import Result
from robodyn.report.limits import LINES
from robodyn.report.pictures.torques import share_figures
from robodyn.report.renderers.html import html
from robodyn.report.torques_page import torques_page
from robodyn.support.wording import shortened

SIDES = [f"hand_{side}_{finger}_flex_{k}_joint" for side in ("left", "right") for finger in "abcde" for k in range(4)]


@cache
def many() -> Result:
    """Forty joints, every second of which is beyond its limit of effort."""
    found = robodyn.torques(robot("puma560"), ROBOTS / "puma560_sweep.csv")
    joints = []
    for k, name in enumerate(SIDES):
        joint = replace(found.joints[k % 6], name=name)
        joints.append(replace(joint, effort_limit=(0.5 if k % 2 else 2.0) * abs(joint.peak)))
    return replace(found, joints=tuple(joints))


def page() -> Page:
    return checked(html(torques_page(many(), robot("puma560"), robodyn.Scene(), pictures=False)))


def first_column(text: str) -> list[str]:
    lines = text.splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith("joint "))
    return [line.split()[0] for line in lines[start + 1 : start + 1 + len(SIDES)]]


ORDER = [*SIDES[1::2], *SIDES[::2]]
"""Offenders, then the others, each in the order of the robot."""


def test_offenders_lead_the_tables_and_none_is_dropped() -> None:
    assert first_column(torques_text(many())) == ORDER
    rows = [each.text for each in page().all("th") if each.attributes["scope"] == "row" and each.text in SIDES]
    count = len(SIDES)
    assert rows[:count] == ORDER, "what each joint carries"
    assert rows[count : 2 * count] == ORDER, "what makes the peaks"
    assert rows[2 * count :] == SIDES[1::2], "the limits that are exceeded, more than the verdict names"
    assert count // 2 > LINES + 1


def test_bars_have_every_joint_by_its_whole_name() -> None:
    texts = [
        text for each in share_figures(many().joints) for text in re.findall(r"<text[^>]*>([^<]*)</text>", each.svg)
    ]
    assert [text for text in texts if text.startswith("hand_")] == SIDES


@pytest.mark.parametrize("most", [17, 20, 24])
def test_shortened_names_differ(most: int) -> None:
    names = ["gripper_left_joint", "gripper_right_joint", "gripper_left_inner_joint", "arm", "arm", *SIDES]
    found = shortened(names, most)
    assert len(set(found)) == len(set(names))
    assert found[3:5] == ["arm", "arm"]
    whole = [name for name, short in zip(names, found, strict=True) if short == name]
    assert all(len(short) <= most for short in set(found) - set(whole))
