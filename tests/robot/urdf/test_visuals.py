"""Visual shapes as triangles: closed, as large as they should be, in place; meshes that are missing are named."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest
import trimesh
from helpers.command_line import ROBOTS

from robodyn.report.stage import shapes_of
from robodyn.robot.load import load_description

SHAPES = {
    "box": ((0.1, 0.2, 0.5), 0.01, 0.0),
    "cylinder": ((0.1, 0.4), np.pi * 0.1**2 * 0.4, 0.01),
    "sphere": ((0.3,), 4 / 3 * np.pi * 0.3**3, 0.02),
    "capsule": ((0.1, 0.4), np.pi * 0.1**2 * (0.4 + 4 / 3 * 0.1), 0.02),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_primitives_are_closed_and_as_large_as_they_should_be(shape: str) -> None:
    size, volume, coarse = SHAPES[shape]
    names = {"box": "size", "cylinder": "radius length", "sphere": "radius", "capsule": "radius length"}[shape].split()
    given = (" ".join(map(str, size)),) if shape == "box" else size
    values = " ".join(f'{name}="{x}"' for name, x in zip(names, given, strict=True))
    origin = '<origin xyz="1 2 3" rpy="0.3 -0.2 1.1"/>'
    link = f'<link name="x"><visual>{origin}<geometry><{shape} {values}/></geometry></visual></link>'
    triangles = shapes_of(load_description(f'<robot name="r">{link}</robot>'.encode()))[0]["x"]
    solid = trimesh.Trimesh(**trimesh.triangles.to_kwargs(triangles), process=False)
    solid.merge_vertices(digits_vertex=9)
    solid.update_faces(solid.nondegenerate_faces())
    assert solid.is_watertight
    assert abs(solid.volume) <= volume * (1 + 1e-12)
    assert abs(solid.volume) >= volume * (1 - coarse) * (1 - 1e-12)
    np.testing.assert_allclose(triangles.reshape(-1, 3).mean(axis=0), (1.0, 2.0, 3.0), rtol=0, atol=0.02)


def test_missing_meshes_are_named(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "arm.urdf").write_text((ROBOTS / "meshed_arm.urdf").read_text())
    with caplog.at_level(logging.WARNING):
        found, why = shapes_of(load_description(tmp_path / "arm.urdf"))
    assert why.startswith("8 mesh files are not found or cannot be read, and not drawn: meshes/hub.stl, ")
    assert "hand" not in found
    assert not caplog.records
