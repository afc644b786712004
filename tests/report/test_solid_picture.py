"""Pictures of solids: what is nearer hides what is behind, in whatever order and however long triangles are."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.oracles import ROBOTS
from matplotlib.figure import Figure

from robodyn.programs.vectors import product
from robodyn.report.pictures.robot import PAPER, draw_solids, nearest
from robodyn.solids.mesh.read.load import load_triangles

ACROSS, UP = 60, 45


def seen_one_by_one(triangles: np.ndarray) -> np.ndarray:
    """Return the nearest triangle at the middle of each dot by barycentric coordinates."""
    found = np.full((UP, ACROSS), -1)
    for y, x in np.ndindex(UP, ACROSS):
        depths = {}
        for k, (a, b, c) in enumerate(triangles):
            sides = np.column_stack((b[:2] - a[:2], c[:2] - a[:2]))
            u, v = np.linalg.solve(sides, np.array((x + 0.5, y + 0.5)) - a[:2])
            if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
                depths[k] = a[2] + u * (b - a)[2] + v * (c - a)[2]
        found[y, x] = max(depths, key=depths.__getitem__, default=-1)
    return found


@pytest.mark.parametrize("thin", [1.0, 0.02])
def test_dots_show_the_nearest_triangle(thin: float) -> None:
    """Triangles that pass through one another, half of them long and thin; edges may be off by a dot."""
    triangles = np.random.default_rng(7).uniform(0.0, 45.0, (8, 3, 3))
    triangles[::2, 2] = triangles[::2, 0] + thin * (triangles[::2, 2] - triangles[::2, 0])
    expected, found = seen_one_by_one(triangles), nearest(triangles, ACROSS, UP)
    inside = np.all([np.roll(expected, shift, axis) == expected for shift in (-1, 1) for axis in (0, 1)], axis=0)
    assert (found[inside] == expected[inside]).mean() > 0.97


def test_the_long_faces_of_a_bracket_hide_what_is_behind_them() -> None:
    """The top of its plate, of long triangles, shows nothing of the faces below and behind."""
    mesh = load_triangles(str(ROBOTS / "meshes" / "bracket.stl")).array()
    placed = product(mesh, PAPER.T)
    placed = (placed - placed.min(axis=(0, 1))) * 2.0
    away = np.cross(placed[:, 1] - placed[:, 0], placed[:, 2] - placed[:, 0])[:, 2] < 0.0
    seen = nearest(placed, 250, 250)
    covered = seen[seen >= 0]
    assert len(covered) > 5_000
    assert away[covered].mean() < 0.01


def test_nothing_to_see() -> None:
    axes = Figure().subplots()
    for solids in ([], [(1, np.zeros((0, 3, 3)))], [(0, np.ones((2, 3, 3)))]):
        draw_solids(axes, solids)
    assert not axes.images
