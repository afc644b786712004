"""`robodyn inertia --cavities`: shells in others, wound alike, as parts of them or as cavities."""

from __future__ import annotations

import json

import numpy as np
import pytest
from helpers.command_line import run
from helpers.mesh_samples import binary_stl, box

ROBOT = """<robot name="r"><link name="l"><visual><geometry><mesh filename="part.stl" scale="0.1 0.1 0.1"/></geometry>
</visual></link></robot>"""


@pytest.fixture
def files(tmp_path):
    """A mesh of a cube in a cube, and a robot made of it."""
    (tmp_path / "part.stl").write_bytes(binary_stl(np.concatenate([box((3, 3, 3)), box()])))
    (tmp_path / "robot.urdf").write_text(ROBOT)
    return str(tmp_path / "part.stl"), str(tmp_path / "robot.urdf")


def test_both_readings_of_a_mesh(files):
    outcome = run("inertia", files[0])
    assert "volume          27.00 m^3" in outcome.out
    assert "if it is a cavity, say --cavities (1 m^3 less)" in outcome.out
    outcome = run("inertia", files[0], "--cavities", "--format", "json")
    (found,) = json.loads(outcome.out)["meshes"]
    assert (found["volume"], found["warnings"]) == (26, [])


def test_both_readings_of_a_link(files):
    link = ("inertia", files[1], "--link", "l", "--geometry", "visual")
    outcome = run(*link)
    assert "0.02700 m^3" in outcome.out
    assert "say --cavities (0.001 m^3 less)" in outcome.out
    assert "0.02600 m^3" in run(*link, "--cavities").out


def test_cavities_need_repair(files):
    outcome = run("inertia", files[0], "--cavities", "--no-repair")
    assert (outcome.status, outcome.err.count("\n")) == (2, 1)
