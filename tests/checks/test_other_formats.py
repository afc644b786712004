"""Findings in MJCF: those of the robot, at the elements of the file."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.command_line import run

import robodyn

pytest.importorskip("mujoco")
TEXT = """<mujoco model="arm">
  <worldbody>
    <body name="upper">
      <joint name="shoulder" axis="0 1 0" range="0 90"/>
      <inertial pos="0.2 0 0" mass="2" diaginertia="0.3 0.5 0.4"/>
      <geom type="capsule" size="0.03" fromto="0 0 0 0.4 0 0"/>
      <body name="fore" pos="0.4 0 0">
        <joint name="elbow" axis="0 1 0" damping="0.1"/>
        <joint name="turn" axis="0 0 1"/>
        <geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" density="2700"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def test_findings_are_at_their_bodies(tmp_path: Path) -> None:
    file = tmp_path / "arm.xml"
    file.write_text(TEXT)
    findings = robodyn.check(str(file))
    assert {(found.line, found.code[:3]) for found in findings} == {(3, "RD3")}, "and nothing that is of URDF alone"
    done = run("check", str(file))
    assert "arm.xml:3:5: error RD301" in done.out
    assert '<body name="upper">' in done.out
    file.write_text(TEXT.replace("0.3 0.5 0.4", "0.002 0.03 0.03"))
    assert robodyn.check(str(file)) == ()
    before = file.read_bytes()
    fixed = run("check", str(file), "--fix", "--unsafe-fixes")
    assert (fixed.status, file.read_bytes()) == (0, before)


def test_only_files_are_checked() -> None:
    done = run("check", "-", stdin=TEXT.encode())
    assert (done.status, done.out) == (2, "")
    assert done.err == "error: <stdin>: MJCF and SDF are checked as files (name the file)\n"
