"""The outermost points of a mesh, which stand for its convex hull."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.mesh_samples import binary_stl

from robodyn.checks.meshes.facts import extremes, spread_out
from robodyn.programs.vectors import product
from robodyn.solids.mesh.triangles import BLOCK


def test_no_corner_of_any_block_lies_farther(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of an ellipsoid's points in several blocks, and of one corner far out in the last."""
    monkeypatch.setenv("ROBODYN_CACHE", "0")
    rng = np.random.default_rng(3)
    points = rng.normal(size=(2 * BLOCK + 7, 3, 3))
    points *= (0.3, 0.2, 0.1) / np.linalg.norm(points, axis=2, keepdims=True)
    points[-1, 1] = 0.4, -0.1, 0.2
    (tmp_path / "part.stl").write_bytes(binary_stl(points))
    corners, found = points.reshape(-1, 3).astype(np.float32).astype(float), extremes(tmp_path / "part.stl", "")
    assert found is not None
    assert {*map(tuple, found)} <= {*map(tuple, corners)}
    assert found[found[:, 0].argmax()].tolist() == pytest.approx([0.4, -0.1, 0.2])
    for direction in spread_out(240):
        assert product(found, direction).max() == pytest.approx(product(corners, direction).max(), rel=1e-15)


def test_no_points_of_what_is_no_mesh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROBODYN_CACHE", "0")
    (tmp_path / "part.stl").write_bytes(b"solid")
    assert extremes(tmp_path / "part.stl", "") is None
