"""Pictures of solids: what is nearer hides what is behind, in whatever order and however long triangles are."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.oracles import ROBOTS

from robodyn.programs.vectors import product
from robodyn.report.pictures.solids import PAPER, _nearest, on_paper
from robodyn.solids.mesh.read.load import load_triangles

ACROSS, UP = 60, 45


def seen_one_by_one(triangles: np.ndarray) -> np.ndarray:
    """Return the nearest triangle of each sample by barycentric coordinates."""
    found = np.full((UP, ACROSS), -1)
    for y in range(UP):
        for x in range(ACROSS):
            depths = {}
            for k, (a, b, c) in enumerate(triangles):
                sides = np.column_stack((b[:2] - a[:2], c[:2] - a[:2]))
                u, v = np.linalg.solve(sides, np.array((x + 0.5, y + 0.5)) - a[:2])
                if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
                    depths[k] = a[2] + u * (b - a)[2] + v * (c - a)[2]
            found[y, x] = max(depths, key=depths.__getitem__, default=-1)
    return found.ravel()


@pytest.mark.parametrize("thin", [1.0, 0.02])
def test_each_sample_shows_the_nearest_triangle(thin: float) -> None:
    """Triangles that pass through one another, half of them long and thin, some beyond the edges of the picture."""
    rng = np.random.default_rng(7)
    triangles = rng.uniform(-5.0, 65.0, (12, 3, 3))
    triangles[::2, 2] = triangles[::2, 0] + thin * (triangles[::2, 2] - triangles[::2, 0])
    assert (_nearest(triangles, ACROSS, UP) == seen_one_by_one(triangles)).all()


def test_of_a_convex_solid_only_the_front_is_seen() -> None:
    """The faces of a box that look away from the reader are in no sample; each of the others is."""
    low, high = np.zeros(3), np.array((50.0, 4.0, 30.0))
    corners = np.array([[(low, high)[i][0], (low, high)[j][1], (low, high)[k][2]] for i, j, k in np.ndindex(2, 2, 2)])
    sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    box = np.array([corners[list(three)] for a, b, c, d in sides for three in ((a, b, c), (a, c, d))])
    ((_, placed),) = on_paper([(0, box)])
    placed -= placed.min(axis=(0, 1))
    outward = np.cross(placed[:, 1] - placed[:, 0], placed[:, 2] - placed[:, 0])[:, 2] > 0.0
    assert {*_nearest(placed, 100, 100).tolist()} - {-1} == {*np.flatnonzero(outward).tolist()}


def test_the_long_faces_of_a_bracket_hide_what_is_behind_them() -> None:
    """The top of its plate, of long triangles, shows nothing of the faces below and behind."""
    mesh = load_triangles(str(ROBOTS / "meshes" / "bracket.stl")).array()
    ((_, placed),) = on_paper([(0, mesh)])
    placed = (placed - placed.min(axis=(0, 1))) * 2.0
    normals = np.cross(mesh[:, 1] - mesh[:, 0], mesh[:, 2] - mesh[:, 0])
    away = np.flatnonzero(product(normals, PAPER[2]) < 0.0)
    seen = _nearest(placed, 250, 250)
    assert (seen >= 0).sum() > 5_000
    assert not np.isin(seen, away).any()


def test_nothing_to_see() -> None:
    """No triangles, none that is finite, or all in one point: no picture."""
    assert on_paper([]) == []
    assert on_paper([(0, np.full((1, 3, 3), np.nan)), (1, np.zeros((0, 3, 3)))]) == []
    assert on_paper([(0, np.ones((2, 3, 3)))]) == []
