"""Caps near what they close: the boundary is that of the caps before, and the solid angle too, but for whole turns."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_samples import moved, torus, uv_sphere
from helpers.repaired_meshes import R

from robodyn.solids.mesh.indexed import Edges, Indexed, areas, merged
from robodyn.solids.mesh.region.quadrature import local_caps
from robodyn.solids.mesh.repair.holes import boundary_loops
from robodyn.solids.mesh.repair.inside import winding_numbers


def cone(body, seed=0):
    """Patches by the signs of coordinates, apart by a little, and a cone over all their rims."""
    rng = np.random.default_rng(seed)
    octant = (body.mean(axis=1) > 0) @ (1, 2, 4)
    mesh = merged(np.concatenate([moved(body[octant == k], 1e-4 * rng.normal(size=3)) for k in range(8)]))
    loops = boundary_loops(mesh.faces)
    apex = loops[0][0]
    sides = [(a, b, apex) for loop in loops for a, b in zip([loop[-1], *loop[:-1]], loop, strict=True)]
    return Indexed(mesh.vertices, np.array([side for side in sides if apex not in side[:2]]))


def boundary(faces):
    edges = Edges.between(faces)
    left = edges.balance != 0
    return np.column_stack([edges.ends[left], edges.balance[left]]).tolist()


@pytest.mark.parametrize("body", [uv_sphere(1, 96, 192), torus(1, 0.4, 128, 96)])
def test_the_same_boundary_with_smaller_triangles(body):
    before = cone(moved(body, R=R))
    after = local_caps(before)
    assert len(before.faces) > 512
    assert boundary(after.faces) == boundary(before.faces)
    points = np.random.default_rng(1).normal(size=(40, 3))
    turns = winding_numbers(points, after) - winding_numbers(points, before)
    assert np.abs(turns - np.rint(turns)).max() < 1e-9
    assert areas(after.corners).sum() < areas(before.corners).sum() / 5


def test_few_caps_are_left_as_they_are():
    caps = cone(uv_sphere())
    assert 0 < len(caps.faces) < 512
    assert local_caps(caps) is caps
