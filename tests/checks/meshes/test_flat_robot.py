"""A robot of meshes without thickness."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from helpers.mesh_samples import binary_stl

from robodyn.checks.check import check_one

LINK = """
  <link name="l{k}"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><geometry><mesh filename="flat.stl"/></geometry></visual></link>"""
JOINT = """
  <joint name="j{k}" type="fixed"><parent link="l0"/><child link="l{k}"/></joint>"""


def test_shapes_without_volume_tell_no_unit_of_the_robot(tmp_path: Path) -> None:
    (tmp_path / "flat.stl").write_bytes(binary_stl(np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]], float)))
    parts = "".join(LINK.format(k=k) + (JOINT.format(k=k) if k else "") for k in range(4))
    (tmp_path / "flat.urdf").write_text(f'<robot name="flat">{parts}</robot>')
    codes = {finding.code for finding in check_one(str(tmp_path / "flat.urdf"))}
    assert codes >= {"RD604"}
