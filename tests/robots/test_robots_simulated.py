"""The command in the head of every scene of a simulation, run, and what theory says of its end."""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from helpers.command_line import ROBOTS, shown
from helpers.oracles import reference
from helpers.robot_catalogue import belonging, names, simulation_command
from helpers.robot_files import read_csv

COMMANDS = {
    path.stem: command for name in names() for path in belonging(name, ".toml") if (command := simulation_command(path))
}
STILL = {"meshed_arm", "gripper", "four_bar", "five_bar", "delta", "planar_3rrr", "quadruped"}
"""Robots of other chapters: meshes, mimic joints, and motions that are given."""
Document = Mapping[str, Any]
Check = Callable[[Document], None]


def test_every_robot_of_the_chapter_has_a_simulation() -> None:
    simulated = {shlex.split(command)[2].removeprefix("robots/").removesuffix(".urdf") for command in COMMANDS.values()}
    assert simulated == set(names()) - STILL
    assert set(CHECKS) == set(COMMANDS)


def _near(found: Document, kind: str, bound: float, **expected: float) -> None:
    for name, value in expected.items():
        assert abs(found["final"][kind][name] - value) <= bound, (name, found["final"][kind][name])


def pendulum_a01(found: Document) -> None:
    angle = float(reference("analytic")["A01_pendulum_exact"]["rows"][-1][3]) - np.pi / 2
    _near(found, "q", 1e-7, pivot=angle)


def double_pendulum_chaos(found: Document) -> None:
    q1, q2, v1, v2 = map(float, reference("double_pendulum")["data"]["chaotic(3pi/4,0)"]["5"])
    _near(found, "q", 1e-9, upper=q1, lower=q2)
    _near(found, "qd", 1e-8, upper=v1, lower=v2)


def heavy_top_steady(found: Document) -> None:
    turns = float(reference("analytic")["heavy_top_steady"]["precession_slow"]) * found["duration"]
    _near(found, "q", 1e-9, nutation=np.pi / 6, precession=turns)
    assert found["duration"] == 10.0


def rigid_body_tumble(found: Document) -> None:
    assert max(found["momentum_drift"].values()) <= 1e-12
    assert found["energy"]["drift"] <= 1e-13


def satellite_deploy(found: Document) -> None:
    _near(found, "q", 0.01, left_array=2.2, right_array=2.9)
    assert max(found["momentum_drift"].values()) <= 1e-13


def composite_throw(found: Document) -> None:
    assert max(found["momentum_drift"].values()) <= 1e-11
    assert found["energy"]["drift"] <= 1e-10


def puma_servo(found: Document) -> None:
    """What stays at rest is the weight over kp, the arm's moment of weight in that pose."""
    end = read_csv("puma_reach")
    _near(found, "q", 6e-3, **{name: end[f"q_{name}"][-1] for name in ("waist", "shoulder", "elbow")})
    assert any("401 rows over 4 s; references are cubic splines" in note for note in found["notes"])


def scara_servo(found: Document) -> None:
    end = read_csv("scara_pick_and_place")
    _near(found, "q", 1e-5, **{name: end[f"q_{name}"][-1] for name in ("shoulder", "elbow", "quill")})


def cylindrical_fall(found: Document) -> None:
    """The lift rests on its stop: 9 kg on 20 kN/m, the plunge carried by its own drive from the lift."""
    _near(found, "q", 1e-4, lift=-0.24 - 9.0 * 9.81 / 2e4)
    assert any('"lift" passes its lower limit of -0.24 m by at most 0.03434 m' in note for note in found["notes"])


def puma560_power_cut(found: Document) -> None:
    assert found["energy"]["work"] < -50.0
    held = [note for note in found["notes"] if note.startswith("friction holds ")]
    assert len(held) == 6
    assert any('"shoulder" passes its lower limit of -0.78 rad' in note for note in found["notes"])


def conserving(most: float) -> Check:
    def check(found: Document) -> None:
        assert found["energy"]["drift"] <= most

    return check


CHECKS: dict[str, Check] = {
    "pendulum_a01": pendulum_a01,
    "double_pendulum_chaos": double_pendulum_chaos,
    "heavy_top_steady": heavy_top_steady,
    "rigid_body_tumble": rigid_body_tumble,
    "satellite_deploy": satellite_deploy,
    "composite_throw": composite_throw,
    "puma_servo": puma_servo,
    "scara_servo": scara_servo,
    "cylindrical_fall": cylindrical_fall,
    "puma560_power_cut": puma560_power_cut,
    "two_link_planar_swing_down": conserving(1e-8),
    "two_link_spatial_whirl": conserving(1e-8),
    "four_bars_a02": conserving(1e-6),
    "crank_slider_pump": conserving(1e-6),
}
QUICK = ("pendulum_a01", "rigid_body_tumble", "cylindrical_fall", "crank_slider_pump")


@pytest.mark.parametrize(
    "scene", [pytest.param(name, marks=[pytest.mark.slow] * (name not in QUICK)) for name in CHECKS]
)
def test_it_runs_and_ends_where_theory_says(scene: str) -> None:
    words = shlex.split(COMMANDS[scene])
    assert words[:2] == ["robodyn", "simulate"]
    assert scene.startswith(words[2].removeprefix("robots/").removesuffix(".urdf") + "_")
    assert words[3:5] == ["--scene", f"robots/{scene}.toml"]
    text = shown(*(word.replace("robots/", f"{ROBOTS}/") for word in words[1:]), "--format", "json")
    found = json.loads(text)
    assert found["ended"] is None
    CHECKS[scene](found)
