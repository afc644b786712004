"""A joint that does nothing does 0: what roundings of inputs leave is told beside the largest of its case."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import run

from robodyn.report.measured import bar

LINK = """<link name="{0}"><inertial><origin xyz="0.3 0 0"/><mass value="{1}"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>"""
JOINT = """<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/><origin rpy="{3:.{digits}f} 0 0"/>
<axis xyz="0 0 1"/><limit effort="500" velocity="5" lower="-3" upper="3"/></joint>"""


@pytest.mark.parametrize("digits", [9, 12, 15])
@pytest.mark.parametrize("mass", [1.0, 20.0])
def test_a_joint_that_does_nothing(digits: int, mass: float, tmp_path: Path) -> None:
    """Its axis is vertical but for the digits of a right angle, and it stands still beside one that moves."""
    quarter = np.pi / 2
    links = "".join(LINK.format(*each) for each in (("lift", 10.0 * mass), ("turn", mass)))
    joints = JOINT.format("first", "base", "lift", quarter, digits=digits)
    joints += JOINT.format("idle", "lift", "turn", -quarter, digits=digits)
    (tmp_path / "r.urdf").write_text(f'<robot name="r"><link name="base"/>{links}{joints}</robot>')
    time = np.arange(0.0, 2.0, 0.01)
    q = 0.2 * np.sin(3.0 * time)
    table = np.column_stack((time, q, 0.6 * np.cos(3.0 * time), -1.8 * np.sin(3.0 * time), *([0.0 * time] * 3)))
    head = "time,q_first,qd_first,qdd_first,q_idle,qd_idle,qdd_idle"
    table[:, 1:4] *= [[0.0, 0.0, 0.0]] if mass == 1.0 else [[1.0, 1.0, 1.0]]
    np.savetxt(tmp_path / "m.csv", table, delimiter=",", header=head, comments="")
    out = run("torques", str(tmp_path / "r.urdf"), str(tmp_path / "m.csv"), "--sizing").out
    if mass == 1.0:
        row = next(line for line in out.splitlines() if line.startswith("idle "))
        assert re.split(r"  +", row)[1].split()[0] == "0"
    assert not re.search(r"e-(0[89]|1\d) (N m|%)", out)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_errors_of_nothing_are_zero(scale: float) -> None:
    assert bar(4.2e-13 * scale, 4.2e-13 * scale, scale) == "0"
    assert bar(4.2e-3 * scale, 4.2e-4 * scale, scale) != "0"
