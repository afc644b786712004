"""Help of many options is in groups; slips in names of joints are told, also of a part of a name."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from helpers.command_line import ROBOTS, run

from robodyn.cli.torques import command
from robodyn.support.wording import alternatives

UR = [f"{part}_joint" for part in ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")]


def test_help_of_torques_is_in_groups() -> None:
    text = run("torques", "--help").out
    titles = re.findall(r"^(\S.*):$", text, re.MULTILINE)
    assert titles[:2] == ["The robot and what surrounds it", "The trajectory"]
    assert len(titles) == 7
    assert titles[-1] == "Other options"
    assert text.partition("Other options:\n")[2].strip().startswith("-h, --help")
    for option in (name for each in command.params for name in each.opts if name.startswith("--")):
        assert len(re.findall(rf"^  {option}\b", text, re.MULTILINE)) == 1
    listed = {name for names in command.groups.values() for name in names}
    assert listed <= {name for each in command.params for name in each.opts}


@pytest.mark.parametrize("table", ["friction", "motor", "rotor", "spring", "drive"])
def test_sholder_in_a_scene(table: str, tmp_path: Path) -> None:
    value = {"friction": "coulomb = 1", "motor": "peak = 1", "rotor": "inertia = 1", "spring": "stiffness = 1"}
    (tmp_path / "s.toml").write_text(f"[{table}]\nsholder = {{ {value.get(table, 'torque = 1')} }}\n")
    call = ("torques", str(ROBOTS / "puma560.urdf"), str(ROBOTS / "puma560_sweep.csv"))
    assert "(did you mean 'shoulder'?)" in run(*call, "--scene", str(tmp_path / "s.toml")).err
    text = (ROBOTS / "puma560.urdf").read_text().replace('"shoulder"', '"shoulder_pan_joint"')
    (tmp_path / "ur.urdf").write_text(text)
    found = run("torques", str(tmp_path / "ur.urdf"), call[2], "--scene", str(tmp_path / "s.toml")).err
    assert "(did you mean 'shoulder_pan_joint'?)" in found


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("sholder", "did you mean 'shoulder_pan_joint' or 'shoulder_lift_joint'?"),
        ("elbwo", "did you mean 'elbow_joint'?"),
        ("gripper", "joints: 'shoulder_pan_joint'"),
    ],
)
def test_slips_in_a_part_of_a_name(given: str, meant: str) -> None:
    assert alternatives(given, UR, "joints").startswith(meant)
