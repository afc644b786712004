"""The text report: what it says of robots of every kind, of many joints, and of what rounding leaves."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from helpers.example_robots import real
from helpers.html_pages import checked
from helpers.oracles import ROBOTS, robot
from helpers.report_text import simulation_text, torques_text

import robodyn
from robodyn.loads.result import Result
from robodyn.report.document import text
from robodyn.report.equations.equations import free_body_sections
from robodyn.report.equations.free_body import drawings
from robodyn.report.limits import LINES
from robodyn.report.renderers.pages import html, markdown
from robodyn.report.table import Page
from robodyn.report.torques import torques_json
from robodyn.report.torques_page import torques_page
from robodyn.scene.read import load_scene
from robodyn.simulation.simulate import simulate
from robodyn.support.wording import shortened

CASES = [
    ("scara", "scara_pick_and_place", None),
    ("puma560", "puma560_sweep", "puma560_motors"),
    ("gripper", "gripper_pick", "gripper"),
    ("satellite", "satellite_slew", "satellite"),
    ("rigid_body", "rigid_body_flip", "rigid_body"),
]
SIDES = [f"hand_{side}_{finger}_flex_{k}_joint" for side in ("left", "right") for finger in "abcde" for k in range(4)]
"""Offenders, then the others, each in the order of the robot."""
TINY = re.compile(r"\de-(?:1[2-9]|[2-9]\d|\d{3})")
"""A number that only rounding makes, in cases of newtons and metres."""


@cache
def result(robot: str, table: str, scene: str | None, explain: bool = False) -> Result:
    around = load_scene(ROBOTS / f"{scene}.toml") if scene else robodyn.Scene()
    model = robodyn.load(ROBOTS / f"{robot}.urdf", moving_base=around.moving_base)
    return robodyn.torques(model, ROBOTS / f"{table}.csv", around, explain=explain)


def section(text: str, title: str) -> list[str]:
    """The lines of the part that begins with this title."""
    part = next(part for part in text.split("\n\n") if part.startswith(title))
    return part.splitlines()


@pytest.mark.parametrize(("robot", "table", "scene"), CASES, ids=[case[1] for case in CASES])
def test_every_joint_is_in_the_tables_with_its_peak(robot: str, table: str, scene: str | None) -> None:
    data = result(robot, table, scene)
    text = torques_text(data)
    assert max(map(len, text.partition("\nwarning")[0].splitlines())) <= 150
    narrow = torques_text(data, page=Page(100)).partition("Self-checks")[0]
    assert max(map(len, narrow.splitlines())) <= 100
    if robot == "satellite":
        assert "\nBase wrench: ground on robot, about the base's origin: zero throughout\n" in text
    loads = section(text, "joint ")[1:] if data.joints else []
    for joint, line in zip(data.joints, loads, strict=True):
        name, peak, *_ = line.split()
        assert name == joint.name
        assert abs(float(peak) - joint.peak) <= 5.0001e-4 * abs(joint.peak)
        assert f"% of {joint.effort_limit:g}" in line
    assert text.endswith("\n")
    assert not text.endswith("\n\n")
    assert not re.search(r"\n\n\n| $", text)


def test_friction_that_holds_is_shown_where_there_is_some() -> None:
    lines = section(torques_text(result("gripper", "gripper_pick", "gripper")), "What makes the peaks")
    assert lines[1].endswith("friction holds")
    assert [line.split()[-1] for line in lines[2:]] == ["16.00", "0.3000", "2.000"]


def test_derived_motion_says_method_noise_and_what_it_does_to_the_peak() -> None:
    data = result("puma", "puma_encoder", None)
    text = torques_text(data)
    lines = section(text, "Derived: velocity and acceleration by ")
    assert data.derivation
    for joint, line in zip(data.derivation.joints, lines[2:], strict=True):
        cells = re.split(r"  +", line)
        assert cells[:3] == [joint.name, joint.velocity, "q"]
        assert [float(cell) for cell in cells[3:]] == pytest.approx((joint.noise, joint.quantum, joint.std), rel=0.05)
    assert "error (95 %)" in section(text, "What makes the peaks")[1]


def test_limits_in_one_line_a_joint() -> None:
    data = result("scara", "scara_pick_and_place", None)
    assert "\nNo limit is exceeded.\n" in torques_text(data)
    shoulder, *others = data.joints
    tight = replace(shoulder, effort_limit=100.0, velocity_limit=4.0, upper=shoulder.q_max - 0.125)
    lines = section(torques_text(replace(data, joints=(tight, *others))), "LIMITS EXCEEDED by 1 of 3 joints")
    assert re.split(r"  +", lines[1]) == ["joint", "effort", "velocity", "position"]
    cells = re.split(r"  +", lines[2])
    assert cells[0] == "shoulder"
    assert cells[1] == f"{abs(shoulder.peak):.6g} N m, limit 100"
    assert cells[2] == f"{abs(shoulder.max_speed):.6g} rad/s, limit 4"
    assert cells[3] == f"{shoulder.q_max:.6g} rad, limit {shoulder.q_max - 0.125:.6g}"
    assert len(lines) == 3
    used = (
        replace(shoulder, effort_limit=1.0),
        replace(others[0], effort_limit=None),
        replace(others[1], effort_limit=1e5),
    )
    lines = section(torques_text(replace(data, joints=used, warnings=("first\nline", "second"))), "joint ")
    expected = [f"{100 * abs(shoulder.peak):.0f}% of 1", "-", "<1% of 100000"]
    assert [re.split(r"  +", line)[-2] for line in lines[1:]] == expected
    lines = torques_text(replace(data, warnings=("first\nline", "second"))).splitlines()
    assert lines[-4:] == ["warning: first\\nline", "warning: second", "", "No limit is exceeded."]


def test_explain_names_every_effect_and_why() -> None:
    data = result("gripper", "gripper_pick", "gripper", explain=True)
    text = torques_text(data, explain=True)
    lines = section(text, f"Effects: {data.operations} operations per sample for the torques; numpy: ")
    assert [line.rstrip().endswith(e.verdict.reason) for line, e in zip(lines[2:], data.effects, strict=True)] == (
        [True] * len(data.effects)
    )
    assert all(("  on  " in line) == e.verdict.active for line, e in zip(lines[2:], data.effects, strict=True))
    assert "Effects:" not in torques_text(data)


@cache
def many() -> Result:
    """Forty joints, every second of which is beyond its limit of effort."""
    found = robodyn.torques(robot("puma560"), ROBOTS / "puma560_sweep.csv")
    joints = []
    for k, name in enumerate(SIDES):
        joint = replace(found.joints[k % 6], name=name)
        joints.append(replace(joint, effort_limit=(0.5 if k % 2 else 2.0) * abs(joint.peak)))
    return replace(found, joints=tuple(joints))


def page():
    return checked(html(torques_page(many(), robot("puma560"), robodyn.Scene(), pictures=False)))


def first_column(text: str) -> list[str]:
    lines = text.splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith("joint "))
    return [line.split()[0] for line in lines[start + 1 : start + 1 + len(SIDES)]]


def test_tables_have_the_order_of_the_robot_and_bars_the_worst_first() -> None:
    assert first_column(torques_text(many())) == SIDES
    rows = [each.text for each in page().all("th") if each.attributes["scope"] == "row" and each.text in SIDES]
    count = len(SIDES)
    assert rows[: count // 2] == SIDES[1::2], "twice their limits, before what uses less"
    assert sorted(rows[:count]) == sorted(SIDES)
    assert rows[count : 2 * count] == SIDES, "what each joint carries"
    assert rows[2 * count : 3 * count] == SIDES, "what makes the peaks"
    assert rows[3 * count :] == SIDES[1::2], "the limits that are exceeded, more than the verdict names"
    assert count // 2 > LINES + 1


@pytest.mark.parametrize("most", [17, 20, 24])
def test_shortened_names_differ(most: int) -> None:
    names = ["gripper_left_joint", "gripper_right_joint", "gripper_left_inner_joint", "arm", "arm", *SIDES]
    found = shortened(names, most)
    assert len(set(found)) == len(set(names))
    assert found[3:5] == ["arm", "arm"]
    whole = [name for name, short in zip(names, found, strict=True) if short == name]
    assert all(len(short) <= most for short in set(found) - set(whole))


@cache
def falling() -> Result:
    """The arm in a pose that it keeps while its base falls freely: nothing carries anything."""
    model = robot("puma560", moving_base=True)
    time = np.linspace(0.0, 1.0, 60)
    q, qd, qdd = np.zeros((60, model.nq)), np.zeros((60, model.n)), np.zeros((60, model.n))
    q[:, 3:7] = np.array((0.1, -0.5, 0.3, 0.8)) / math.sqrt(0.99)
    q[:, 7:] = np.linspace(0.3, 1.9, model.nq - 7)
    qdd[:, 3:6] = (0.0, 0.0, -9.81 * (1.0 + np.finfo(float).eps))
    q[:, 2], qd[:, 5] = -9.81 / 2 * time**2, -9.81 * time
    scene = robodyn.Scene(moving_base=True)
    return robodyn.torques(model, robodyn.motion(model, time, q, qd, qdd), scene, sizing=True, history=True)


def test_free_fall_carries_nothing_in_text_and_page() -> None:
    found = falling()
    peaks = [abs(joint.peak) for joint in found.joints]
    assert 0.0 < max(peaks) < 1e-12, "rounding leaves something, or this tests nothing"
    for words in (torques_text(found), _page(found)):
        assert not TINY.search(words.replace("<1e-12", "")), words
    assert any(f'"peak": {joint.peak!r}' in torques_json(found) for joint in found.joints if joint.peak), "all digits"
    assert "zero throughout" in torques_text(found)


def _page(found: Result) -> str:
    model, scene = robot("puma560", moving_base=True), robodyn.Scene(moving_base=True)
    return markdown(torques_page(found, model, scene, pictures=False))


def test_noise_is_no_arrow_of_a_drawing() -> None:
    """A wrist at rest whose moments are the rounding of forces at the end of an arm."""
    model = real("ur5_robot")
    found = robodyn.free_bodies(model, [0.0] * model.n)
    moments = [float(np.linalg.norm(a.moment)) for body in found.bodies for a in body.actions]
    assert any(0.0 < x < 1e-11 for x in moments), "rounding leaves something, or this tests nothing"
    for _, svg in drawings(found, "at rest"):
        assert not TINY.search(svg)
    assert not TINY.search(text(free_body_sections(found, "at rest")).replace("<1e-12", ""))


def test_simulations_show_no_noise() -> None:
    model = robot("heavy_top")
    scene = load_scene(ROBOTS / "heavy_top_steady.toml")
    found = simulate(model, scene, duration=0.2)
    assert 0.0 < np.abs(found.qdd).max() < 1e-10
    text = simulation_text(found)
    assert not TINY.search(text.replace("<1e-12", "")), text
