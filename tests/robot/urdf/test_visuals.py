"""Visual shapes as triangles: those that need no mesh agree with trimesh's, whose that yourdfpy reads are in place."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest
import trimesh
from helpers.command_line import ROBOTS

from robodyn.report.pictures.robot import _of_meshes, primitive, visuals
from robodyn.robot.urdf.description import load_description
from robodyn.robot.urdf.parts import Geometry, Origin

SHAPES = {
    "box": ((0.1, 0.2, 0.5), 0.01, 0.0),
    "cylinder": ((0.1, 0.4), np.pi * 0.1**2 * 0.4, 0.01),
    "sphere": ((0.3,), 4 / 3 * np.pi * 0.3**3, 0.02),
    "capsule": ((0.1, 0.4), np.pi * 0.1**2 * (0.4 + 4 / 3 * 0.1), 0.02),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_primitives_are_closed_and_as_large_as_they_should_be(shape: str) -> None:
    size, volume, coarse = SHAPES[shape]
    geometry = Geometry("visual", Origin((1.0, 2.0, 3.0), (0.3, -0.2, 1.1)), shape, size)
    triangles = primitive(geometry)
    solid = trimesh.Trimesh(**trimesh.triangles.to_kwargs(triangles), process=False)
    solid.merge_vertices(digits_vertex=9)
    solid.update_faces(solid.nondegenerate_faces())
    assert solid.is_watertight
    assert abs(solid.volume) <= volume * (1 + 1e-12)
    assert abs(solid.volume) >= volume * (1 - coarse) * (1 - 1e-12)
    np.testing.assert_allclose(triangles.reshape(-1, 3).mean(axis=0), (1.0, 2.0, 3.0), rtol=0, atol=0.02)


@pytest.mark.parametrize("name", ["puma560", "scara", "two_link_planar"])
def test_both_ways_fill_the_same_boxes(name: str) -> None:
    description = load_description(ROBOTS / f"{name}.urdf")
    ours, theirs = visuals(description), _of_meshes(description)
    assert ours.triangles.keys() == theirs.triangles.keys()
    for link, triangles in ours.triangles.items():
        other = theirs.triangles[link]
        for end in (np.min, np.max):
            np.testing.assert_allclose(end(triangles, axis=(0, 1)), end(other, axis=(0, 1)), rtol=0, atol=4e-3)


def test_meshes_are_found_and_missing_ones_named(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    found = visuals(load_description(ROBOTS / "meshed_arm.urdf"))
    assert found.missing == ()
    assert set(found.triangles) >= {"hand", "upper_arm", "forearm"}
    (tmp_path / "arm.urdf").write_text((ROBOTS / "meshed_arm.urdf").read_text())
    with caplog.at_level(logging.WARNING):
        alone = visuals(load_description(tmp_path / "arm.urdf"))
    assert any(name.endswith("bracket.stl") for name in alone.missing)
    assert "hand" not in alone.triangles
    assert not caplog.records
