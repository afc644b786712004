"""The JSON document of `torques`: its keys, its precision, and that it is alone on standard output."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from helpers.command_line import ARM, ROBOTS, motion, run

from robodyn.loads.torques import torques
from robodyn.report.torques_json import torques_json
from robodyn.robot.load import load
from robodyn.scene.read import load_scene

CASES = [
    ("scara", "scara_pick_and_place", None),
    ("puma", "puma_encoder", None),
    ("puma560", "puma560_sweep", "puma560_motors"),
    ("gripper", "gripper_pick", "gripper"),
    ("satellite", "satellite_slew", "satellite"),
    ("rigid_body", "rigid_body_flip", "rigid_body"),
]
TOP = [
    "robot",
    "samples",
    "duration",
    "gravity",
    "joints",
    "base_wrench",
    "effects",
    "checks",
    "plan",
    "derivatives",
    "time_origin",
    "held",
    "limits_exceeded",
    "limits",
    "within_limits",
    "verdict",
    "doubts",
    "warnings",
]
JOINT = [
    "name",
    "unit",
    "peak",
    "peak_time",
    "peak_row",
    "peak_speed",
    "rms",
    "mean",
    "cubic_mean",
    "max_speed",
    "max_speed_time",
    "max_speed_row",
    "torque_at_max_speed",
    "peak_power",
    "least_power",
    "work_positive",
    "work_negative",
    "hold",
    "effort_limit",
    "velocity_limit",
    "seconds_over_effort",
    "seconds_over_velocity",
    "lower",
    "upper",
    "q_min",
    "q_max",
    "uncertainty",
    "error_bar",
    "effort_margin",
    "velocity_margin",
    "shares",
]
EFFECT = ["name", "active", "reason", "share", "operations"]
DERIVED = ["name", "velocity", "acceleration", "source", "quantum", "noise", "std"]


def files(robot: str, table: str, scene: str | None) -> list[str]:
    more = ["--scene", str(ROBOTS / f"{scene}.toml")] if scene else []
    return [str(ROBOTS / f"{robot}.urdf"), str(ROBOTS / f"{table}.csv"), *more]


def document(*args: str) -> dict[str, Any]:
    outcome = run("torques", *args, "--format", "json")
    assert (outcome.status, outcome.err) == (0, "")
    found: dict[str, Any] = json.loads(outcome.out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    return found


@pytest.mark.parametrize(("robot", "table", "scene"), CASES, ids=[case[1] for case in CASES])
def test_keys(robot: str, table: str, scene: str | None) -> None:
    found = document(*files(robot, table, scene))
    assert sorted(found) == sorted(TOP)
    for joint in found["joints"]:
        assert sorted(joint) == sorted(JOINT)
    assert list(found["base_wrench"]) == ["fx", "fy", "fz", "mx", "my", "mz", "fxy", "mxy"]
    assert all(list(part) == ["peak", "peak_time", "rms"] for part in found["base_wrench"].values())
    assert all(list(effect) == EFFECT for effect in found["effects"])
    assert list(found["checks"]) == ["energy_balance", "first_law", "second_law", "power", "samples"]
    assert list(found["checks"]["energy_balance"]) == (
        ["work", "energy_change", "residual", "quadrature_error", "turnover", "largest_residual", "consistent"]
    )
    assert list(found["plan"]) == ["executor", "operations", "reason"]
    assert all(list(joint) == DERIVED for joint in found["derivatives"])


def test_explain_adds_what_an_effect_costs() -> None:
    found = document(*files("scara", "scara_pick_and_place", None), "--explain")
    assert all(list(effect) == [*EFFECT, "operations_saved_without"] for effect in found["effects"])


def test_derivatives_are_data() -> None:
    found = document(*files("puma", "puma_encoder", None))
    assert {joint["name"] for joint in found["derivatives"]} == {"waist", "shoulder", "elbow"}
    for joint in found["derivatives"]:
        assert joint["std"] > joint["noise"] > 0.0


@pytest.mark.parametrize(("robot", "table", "scene"), CASES, ids=[case[1] for case in CASES])
def test_numbers_are_those_of_the_library_to_the_last_bit(robot: str, table: str, scene: str | None) -> None:
    found = document(*files(robot, table, scene))
    around = load_scene(ROBOTS / f"{scene}.toml") if scene else None
    model = load(ROBOTS / f"{robot}.urdf", moving_base=bool(around and around.moving_base))
    path = ROBOTS / f"{table}.csv"
    result = torques(model, path, around) if around else torques(model, path)
    assert found["duration"] == result.duration
    for joint, expected in zip(found["joints"], result.joints, strict=True):
        for key in JOINT:
            assert joint[key] == getattr(expected, key), key
    for part in result.base_wrench:
        assert found["base_wrench"][part.name] == {"peak": part.peak, "peak_time": part.peak_time, "rms": part.rms}
    assert found["checks"]["energy_balance"]["residual"] == result.checks.energy_balance.residual
    assert found["warnings"] == list(result.warnings)


def test_margins_and_shares_add_up() -> None:
    for joint in document(*files("puma560", "puma560_sweep", "puma560_motors"))["joints"]:
        assert joint["effort_margin"] == joint["effort_limit"] - abs(joint["peak"])
        assert joint["velocity_margin"] == joint["velocity_limit"] - abs(joint["max_speed"])
        assert math.fsum(joint["shares"].values()) == pytest.approx(joint["peak"], rel=0, abs=1e-12 * 100)


def test_absent_limits_are_null(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(re.sub("<limit[^>]*>", "", ARM).replace("revolute", "continuous"))
    (tmp_path / "arm.csv").write_text(motion(5))
    for joint in document(str(tmp_path / "arm.urdf"), str(tmp_path / "arm.csv"))["joints"]:
        limits = ("effort_limit", "effort_margin", "velocity_limit", "velocity_margin", "lower", "upper")
        assert [joint[key] for key in limits] == [None] * 6


def test_exceeded_limits_are_data(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(
        ARM.replace('upper="3"', 'upper="0.01"').replace('velocity="5"', 'velocity="0.15"')
    )
    (tmp_path / "arm.csv").write_text(motion(10))
    during, never = {"time": 0.0, "seconds": 0.09}, {"time": None, "seconds": None}
    assert document(str(tmp_path / "arm.urdf"), str(tmp_path / "arm.csv"))["limits_exceeded"] == [
        {"joint": "elbow", "quantity": "velocity", "value": 0.2, "limit": 0.15, "unit": "rad/s", **during},
        {"joint": "elbow", "quantity": "position", "value": 0.2 * 9 / 100, "limit": 0.01, "unit": "rad", **never},
    ]


def test_the_document_does_not_change_from_run_to_run() -> None:
    call = files("gripper", "gripper_pick", "gripper")
    assert run("torques", *call, "--format", "json").out == run("torques", *call, "--format", "json").out


def test_what_json_cannot_say_is_never_written() -> None:
    result = torques(load(ROBOTS / "scara.urdf"), ROBOTS / "scara_pick_and_place.csv")
    for value in (math.nan, math.inf):
        with pytest.raises(ValueError, match="JSON"):
            torques_json(replace(result, duration=value))
