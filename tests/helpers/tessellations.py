"""Tessellations of smooth solids, with every corner on the surface, as CAD programs make them.

Each takes the number of facets of a full turn.
"""

from __future__ import annotations

from math import ceil, pi

import numpy as np

from helpers import mesh_samples as samples


def quads(grid: np.ndarray) -> np.ndarray:
    """Triangles over a grid (rows, columns, 3) that closes along the columns; those without area left out."""
    return open_quads(np.concatenate([grid, grid[:, :1]], axis=1))


def open_quads(grid: np.ndarray) -> np.ndarray:
    """Triangles over a grid (rows, columns, 3); those without area left out."""
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    found = np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])
    p, q, r = found.transpose(1, 0, 2)
    return found[(p != q).any(axis=1) & (q != r).any(axis=1) & (r != p).any(axis=1)]


def prism(rings: list[np.ndarray], height: float) -> np.ndarray:
    """Over an outline (n, 2) counter-clockwise and holes clockwise."""
    from manifold3d import triangulate

    flat = np.concatenate(rings)
    cap = triangulate(rings)
    low, high = (np.column_stack([flat, np.full(len(flat), z)]) for z in (-height / 2, height / 2))
    sides, first = [], 0
    for ring in rings:
        i = first + np.arange(len(ring))
        j = np.roll(i, -1)
        sides += [np.stack([low[i], low[j], high[j]], axis=1), np.stack([low[i], high[j], high[i]], axis=1)]
        first += len(ring)
    return np.concatenate([high[cap], low[cap[:, ::-1]], *sides])


def rounded_corners(half: np.ndarray, r: float, facets: int) -> np.ndarray:
    n = ceil(facets / 4)
    steps = np.linspace(0, pi / 2, n + 1)
    turn = np.concatenate([steps + k * pi / 2 for k in range(4)])
    signs = np.repeat([(1, 1), (-1, 1), (-1, -1), (1, -1)], n + 1, axis=0)
    rise = np.concatenate([steps - pi / 2, steps])
    up = np.repeat([-1, 1], n + 1)
    x, y = (np.outer(np.cos(rise), part) * r for part in (np.cos(turn), np.sin(turn)))
    z = np.broadcast_to((r * np.sin(rise))[:, None], x.shape)
    x, y, z = (np.where(np.abs(part) < 1e-12 * r, 0.0, part) for part in (x, y, z))
    flat = np.stack([x + signs[:, 0] * half[0], y + signs[:, 1] * half[1], z + up[:, None] * half[2]], axis=-1)
    bottom, top = (
        [(s * half[0], t * half[1], u * (half[2] + r)) for s, t in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
        for u in (-1, 1)
    )
    ends = [samples.corners(bottom, [(0, 2, 1), (0, 3, 2)]), samples.corners(top, [(0, 1, 2), (0, 2, 3)])]
    return np.concatenate([quads(flat), *ends])


def icosphere(times: int) -> np.ndarray:
    """An icosahedron on the unit sphere, each triangle cut in four so many times."""
    points = np.array([(s, t * (1 + 5**0.5) / 2, 0) for s in (-1, 1) for t in (-1, 1)], float)
    found = hull(np.concatenate([np.roll(points, k, axis=1) for k in range(3)]) / np.linalg.norm(points[0]))
    for _ in range(times):
        found = quartered(found)
    return found


def quartered(sphere: np.ndarray) -> np.ndarray:
    """Each triangle on a unit sphere cut in four."""
    a, b, c = sphere.transpose(1, 0, 2)
    ab, bc, ca = a + b, b + c, c + a
    found = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    unit: np.ndarray = found / np.linalg.norm(found, axis=2, keepdims=True)
    return unit


def hull(points: np.ndarray) -> np.ndarray:
    from scipy.spatial import ConvexHull

    found = points[ConvexHull(points).simplices]
    normals = np.cross(found[:, 1] - found[:, 0], found[:, 2] - found[:, 0])
    inwards = np.einsum("ij,ij->i", normals, found[:, 0]) < 0
    found[inwards] = found[inwards][:, ::-1]
    return found
