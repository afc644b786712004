"""The rims of a surface put together where they nearly meet."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from robodyn.solids.mesh.indexed import Edges, Indexed, components
from robodyn.solids.mesh.triangles import Floats

_NEAR = 1e-6
"""Distance of corners that rounding may have parted, over the size of the surface."""

_CELL = 4.0
"""Times this distance, the side of the cells in which near corners are sought."""


def welded(mesh: Indexed) -> Indexed:
    """The mesh with corners on its rims made one where rounding may have parted them, without faces that vanish then.

    The same object where there are none.

    Corners within 1e-6 of the surface's size share a cell of at least one of eight lattices, shifted by half a cell.
    """
    edges = Edges.between(mesh.faces)
    rim = np.unique(edges.ends[edges.count == 1])
    points = mesh.vertices[rim]
    cell = _CELL * _NEAR * float(np.ptp(mesh.vertices[np.unique(mesh.faces)], axis=0).max())
    if not len(rim) or not cell > 0:
        return mesh
    links = [_neighbours(points / cell + shift) for shift in product((0.0, 0.5), repeat=3)]
    label = components(len(rim), *np.concatenate(links, axis=1))
    _, first = np.unique(label, return_index=True)
    if len(first) == len(rim):
        return mesh
    name = np.arange(len(mesh.vertices))
    name[rim] = rim[first[label]]
    a, b, c = faces = name[mesh.faces].T
    return replace(mesh, faces=faces.T[(a != b) & (b != c) & (c != a)])


def _neighbours(points: Floats) -> np.ndarray[tuple[int, int], np.dtype[np.int64]]:
    """(2, n) pairs of points that follow each other in the same unit cell."""
    cells = np.floor(points)
    order = np.lexsort(cells.T)
    same = (np.diff(cells[order], axis=0) == 0).all(axis=1)
    return np.stack([order[:-1][same], order[1:][same]])
