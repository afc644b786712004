"""Robots without joints that move, as flying ones are described: every command answers, or says what frees the base."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.command_line import refused, run
from helpers.small_robots import joint, link, urdf

PARTS = (link("body", 1.5, (0, 0, 0.1), (0.01, 0, 0, 0.02, 0, 0.03)), link("rotor", 0.1, (0, 0, 0), (1e-3,) * 6))
FREE = ("--scene", "free.toml")
STILL = "copter.urdf: nothing can move: the robot has no joint that moves, and its base is fixed (free its base: "
ANSWERED = [
    ("info", "copter.urdf"),
    ("inertia", "copter.urdf"),
    ("fbd", "copter.urdf"),
    ("torques", "copter.urdf", "still.csv"),
    ("torques", "copter.urdf", "hover.csv", "--report", "r.html", *FREE),
    ("torques", "copter.urdf", "example.csv", "--example", *FREE),
    ("simulate", "copter.urdf", "--duration", "0.1", "--format", "json", *FREE),
    ("equations", "copter.urdf", *FREE),
    ("linearize", "copter.urdf", *FREE),
    ("export", "copter.urdf", "--to", "c", *FREE),
    ("fbd", "copter.urdf", *FREE),
]
REFUSED = [
    ("simulate", "copter.urdf"),
    ("equations", "copter.urdf"),
    ("linearize", "copter.urdf"),
    ("equations", "copter.urdf", "--form", "dae"),
    ("export", "copter.urdf", "--to", "c"),
    ("accuracy", "copter.urdf", "still.csv"),
    ("accuracy", "copter.urdf", "fixed.toml"),
]


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("copter.urdf").write_bytes(urdf(*PARTS, joint("hub", "body", "rotor", "fixed", xyz=(0.2, 0, 0))))
    Path("free.toml").write_text('[base]\nmotion = "moving"\n')
    Path("fixed.toml").write_text("gravity = [0, 0, -9.81]\n")
    Path("still.csv").write_text("time\n0\n0.1\n0.2\n")
    row = ",0,0,1,0,0,0,1\n"
    head = "time,base_x,base_y,base_z,base_qx,base_qy,base_qz,base_qw\n"
    Path("hover.csv").write_text(head + "".join(f"{k / 10}{row}" for k in range(12)))


@pytest.mark.parametrize("call", ANSWERED, ids=" ".join)
def test_is_answered(call: tuple[str, ...]) -> None:
    outcome = run(*call)
    assert outcome.status == 0, outcome.err
    assert outcome.out


@pytest.mark.parametrize("call", REFUSED, ids=" ".join)
def test_says_how_to_free_the_base(call: tuple[str, ...]) -> None:
    refused(run(*call), f'{STILL}[base] motion = "moving" in a scene)\n')
