"""Winding numbers by clusters against those by single triangles."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.mesh_samples import box, moved, torus, uv_sphere
from helpers.repaired_meshes import R

from robodyn.solids.mesh.indexed import Indexed, merged
from robodyn.solids.mesh.region.winding_tree import WindingTree
from robodyn.solids.mesh.repair.inside import winding_numbers

AROUND = np.random.default_rng(0).uniform(-1.5, 1.5, size=(400, 3))


def patch(seed):
    """Some faces of a torus and of a sphere, which leave large and small gaps."""
    rng = np.random.default_rng(seed)
    whole = np.concatenate([torus(1, 0.4, 48, 24), moved(uv_sphere(0.5, 16, 32), (0.1, 0.2, 0.3), R)])
    return merged(whole[(rng.random(len(whole)) < 0.7) & (whole.mean(axis=1) @ rng.normal(size=3) < 0.3)])


@pytest.mark.parametrize("seed", range(6))
def test_many_triangles_within_five_thousandths(seed):
    mesh = patch(seed)
    error = WindingTree.of(mesh).numbers(AROUND) - winding_numbers(AROUND, mesh)
    assert np.abs(error).max() < 5e-3
    assert np.sqrt((error**2).mean()) < 1e-3


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_near_triangles_are_exact(scale):
    """A box has too few for a cluster to be far from points within it."""
    mesh = merged(moved(box()[:-1], (5, 6, 7), R) * scale)
    points = moved(AROUND[:, None] / 4, (5, 6, 7), R)[:, 0] * scale
    np.testing.assert_allclose(WindingTree.of(mesh).numbers(points), winding_numbers(points, mesh), rtol=0, atol=1e-9)


def test_far_away_a_cluster_is_a_dipole_to_first_order():
    """The error falls with the fourth power of the distance, the winding number with the second."""
    mesh = merged(patch(0).corners[:12])
    tree = WindingTree.of(mesh)
    away = mesh.corners.mean(axis=(0, 1)) + R[:1] * np.array([[10.0], [20.0], [40.0]])
    exact = winding_numbers(away, mesh)
    error = np.abs(tree.numbers(away) - exact)
    assert (error < 1e-2 * np.abs(exact)).all()
    assert (error[1:] < error[:-1] / 12).all()


def test_the_sides_of_a_plane_cap_are_told_apart_however_near():
    """At one millionth of its size from a disc of many triangles the number is 1/2 less what is seen past its rim."""
    angle = np.linspace(0, 2 * np.pi, 201)[:-1]
    rim = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    faces = np.stack([np.zeros(198, int), np.arange(1, 199), np.arange(2, 200)], axis=1)
    disc = Indexed(moved(rim[:, None], (1, 2, 3), R)[:, 0], faces)
    places = 0.7 * rim[::9] * np.linspace(0.1, 1, 23)[:, None]
    tree = WindingTree.of(disc)
    for side in (1e-6, -1e-6):
        near = np.column_stack([places[:, :2], np.full(len(places), side)])
        found = tree.numbers(moved(near[:, None], (1, 2, 3), R)[:, 0]) * -np.sign(side)
        assert (found < 0.5).all()
        assert (found > 0.5 - 1e-5).all()


def test_nothing_has_no_winding_number():
    nothing = Indexed(np.zeros((1, 3)), np.empty((0, 3), np.int64))
    assert WindingTree.of(nothing).numbers(np.ones((2, 3))).tolist() == [0, 0]
