"""Symmetry and facets of meshes of very many triangles: within memory, or left out with a note."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from helpers.mesh_samples import torus

from robodyn.errors import MeshError
from robodyn.solids.mass_properties import mass_properties
from robodyn.solids.mesh.asymmetry import TriangleSet, mirror


def test_above_a_limit_neither_is_sought_though_asked(monkeypatch):
    body = torus()
    found = mass_properties(body, symmetry=True, tessellation=True)
    assert found.symmetry is not None
    assert found.tessellation is not None
    monkeypatch.setenv("ROBODYN_LIMITS", f"mesh_shape={len(body) - 1}")
    found = mass_properties(body, symmetry=True, tessellation=True)
    assert found.symmetry is None
    assert found.tessellation is None
    assert [note.partition(",")[0] for note in found.notes] == [
        "symmetry: not sought above 1023 triangles",
        "tessellation: not sought above 1023 triangles",
    ]
    assert found.body.volume > 0
    with pytest.raises(MeshError, match="ROBODYN_LIMITS=mesh_shape=NUMBER"):
        mass_properties(body, symmetrize=True)


def test_triangles_are_compared_in_blocks():
    corners = torus(rings=512, sectors=256)
    tracemalloc.start()
    same = TriangleSet(corners, 2.5)
    assert same.invariant(np.diag((-1.0, -1.0, 1.0)))
    assert not same.invariant(mirror(np.array((0.6, 0.8, 0.0))))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < corners.nbytes
