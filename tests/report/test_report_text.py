"""The text report: what it says of robots of every kind, and that it agrees with the data."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
from helpers.report_text import torques_text

import robodyn
from robodyn.loads.result import Result
from robodyn.report.table import Page
from robodyn.scene.read import load_scene

ROBOTS = Path(__file__).parent.parent.parent / "robots"
CASES = [
    ("scara", "scara_pick_and_place", None),
    ("cylindrical", "cylindrical_transfer", None),
    ("puma", "puma_encoder", None),
    ("puma560", "puma560_sweep", "puma560_motors"),
    ("gripper", "gripper_pick", "gripper"),
    ("satellite", "satellite_slew", "satellite"),
    ("rigid_body", "rigid_body_flip", "rigid_body"),
]


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
    loads = section(text, "joint ")[1:] if data.joints else []
    for joint, line in zip(data.joints, loads, strict=True):
        name, peak, *_ = line.split()
        assert name == joint.name
        assert abs(float(peak) - joint.peak) <= 5.0001e-4 * abs(joint.peak)
        assert f"% of {joint.effort_limit:g}" in line
    assert text.endswith("\n")
    assert not text.endswith("\n\n")
    assert not re.search(r"\n\n\n| $", text)


@pytest.mark.parametrize(("robot", "table", "scene"), CASES, ids=[case[1] for case in CASES])
def test_lines_are_short_enough_to_read(robot: str, table: str, scene: str | None) -> None:
    tables = torques_text(result(robot, table, scene)).partition("\nwarning")[0]
    assert max(map(len, tables.splitlines())) <= 150
    narrow = torques_text(result(robot, table, scene), page=Page(100)).partition("Self-checks")[0]
    assert max(map(len, narrow.splitlines())) <= 100


def test_shares_of_each_peak_add_up_as_shown() -> None:
    data = result("scara", "scara_pick_and_place", None)
    for line in section(torques_text(data), "What makes the peaks")[2:]:
        _, gravity, inertia, coriolis, peak, *_ = line.split()
        assert float(gravity) + float(inertia) + float(coriolis) == pytest.approx(float(peak), abs=0.06)


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


def test_a_base_that_bears_nothing_takes_one_line() -> None:
    text = torques_text(result("satellite", "satellite_slew", "satellite"))
    assert "\nBase wrench: ground on robot, about the base's origin: zero throughout\n" in text
    assert "e-17" not in text


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


def test_use_of_limits() -> None:
    data = result("scara", "scara_pick_and_place", None)
    shoulder, elbow, quill = data.joints
    odd = (replace(shoulder, effort_limit=1.0), replace(elbow, effort_limit=None), replace(quill, effort_limit=1e5))
    lines = section(torques_text(replace(data, joints=odd)), "joint ")
    used = f"{100 * abs(shoulder.peak):.0f}% of 1"
    assert [re.split(r"  +", line)[-2] for line in lines[1:]] == [used, "-", "<1% of 100000"]


def test_explain_names_every_effect_and_why() -> None:
    data = result("gripper", "gripper_pick", "gripper", explain=True)
    text = torques_text(data, explain=True)
    lines = section(text, f"Effects: {data.operations} operations per sample for the torques; numpy: ")
    assert [line.rstrip().endswith(e.verdict.reason) for line, e in zip(lines[2:], data.effects, strict=True)] == (
        [True] * len(data.effects)
    )
    assert all(("  on  " in line) == e.verdict.active for line, e in zip(lines[2:], data.effects, strict=True))
    assert "Effects:" not in torques_text(data)


def test_what_vanishes_beside_the_energy_that_went_about_is_zero() -> None:
    energy = section(torques_text(result("puma560", "puma560_sweep", None)), "Self-checks")[1]
    assert energy == "energy: work 0 J, stored 0 J, residual 0 J (sampling explains 0 J)"


def test_warnings_come_before_the_verdict_each_on_a_line() -> None:
    data = result("puma560", "puma560_sweep", None)
    lines = torques_text(replace(data, warnings=("first\nline", "second"))).splitlines()
    assert lines[-4:] == ["warning: first\\nline", "warning: second", "", "No limit is exceeded."]
