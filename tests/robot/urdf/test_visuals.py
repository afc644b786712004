"""Visual shapes as triangles: each closed and of its volume, and all where yourdfpy has them."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest
import trimesh
import yourdfpy
from helpers.command_line import ROBOTS

from robodyn.report.pictures.robot import primitive, visuals
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
    triangles = primitive(Geometry("visual", Origin(), shape, size))
    solid = trimesh.Trimesh(**trimesh.triangles.to_kwargs(triangles), process=False)
    solid.merge_vertices(digits_vertex=9)
    solid.update_faces(solid.nondegenerate_faces())
    assert solid.is_watertight
    assert abs(solid.volume) <= volume * (1 + 1e-12)
    assert abs(solid.volume) >= volume * (1 - coarse) * (1 - 1e-12)
    np.testing.assert_allclose(triangles.reshape(-1, 3).mean(axis=0), 0.0, rtol=0, atol=0.02)


@pytest.mark.parametrize("name", ["puma560", "scara", "meshed_arm"])
def test_yourdfpy_has_them_at_the_same_places(name: str) -> None:
    ours, scene = (
        visuals(load_description(ROBOTS / f"{name}.urdf")).triangles,
        yourdfpy.URDF.load(ROBOTS / f"{name}.urdf", mesh_dir=str(ROBOTS)),
    )
    theirs: dict[str, list[np.ndarray]] = {}
    for node in scene.scene.graph.nodes_geometry:
        matrix, geometry = scene.scene.graph.get(node)
        link = scene.scene.graph.transforms.parents[node]
        local = np.linalg.inv(scene.scene.graph.get(link)[0]) @ matrix
        theirs.setdefault(link, []).append(scene.scene.geometry[geometry].vertices @ local[:3, :3].T + local[:3, 3])
    assert ours.keys() == theirs.keys()
    for link, triangles in ours.items():
        for end in (np.min, np.max):
            other = end(np.concatenate(theirs[link]), axis=0)
            np.testing.assert_allclose(end(triangles, axis=(0, 1)), other, rtol=0, atol=4e-3)


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
