"""Edges at which facets meet at small angles, and what they say about the surface that they stand for."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import radians
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import Array, arctan2
from robodyn.solids.mesh.indexed import Mask, components, hashed, paired
from robodyn.support.floats import Floats

Integers = NDArray[np.int64]

SHARPEST = radians(65)
"""Facets that meet at a larger angle are meant so, unless both belong to curved faces."""

_WIDEST = radians(120)

BENT = 1e-3
"""Below this many radians an angle may be a rounding error."""

_FLAT = 1e-5
_EDGES = 1 << 14


@dataclass(frozen=True, eq=False)
class BentEdges:
    """Edges of two triangles, from start to end (3, k), that meet at an angle below 120 degrees which is not zero.

    Attributes:
        angle: (k,) between the normals [rad], positive where the surface is convex.
        heights: (2, k) of the two triangles over the edge.
        feet: (2, k) where the corners opposite to the edge stand over it, from 0 at its start to 1 at its end.
        outward: (2, 3, k) unit vectors across the edge in the plane of either triangle, out of it.
        triangles: (2, k) their numbers. flat: (m,) whether a triangle lies in one plane with another one.
        facet: (m,) number of the connected triangles in one plane that each belongs to. areas: (m,) of these.
    """

    start: Floats
    end: Floats
    angle: Floats
    length: Floats
    heights: Floats
    feet: Floats
    outward: Floats
    triangles: Integers
    flat: NDArray[np.bool_]
    facet: Integers
    areas: Floats

    def among(self, chosen: NDArray[np.bool_]) -> BentEdges:
        """Return some of them."""
        if chosen.all():
            return self
        columns = {name: getattr(self, name)[..., chosen] for name in _COLUMNS}
        return replace(self, **columns)


_COLUMNS = ("start", "end", "angle", "length", "heights", "feet", "outward", "triangles")


def bent_edges(corners: Array) -> BentEdges:
    """The bent edges of triangles (m, 3, 3), wound outwards, that have the same bits in both triangles of an edge."""
    X = np.ascontiguousarray(corners.transpose(1, 2, 0))
    points = np.ascontiguousarray(X.transpose(0, 2, 1)).reshape(-1, 3)
    u, v = X[1] - X[0], X[2] - X[0]
    normals = np.stack([u[i - 2] * v[i - 1] - u[i - 1] * v[i - 2] for i in range(3)], axis=1)
    hashes = hashed(X)
    one, other = paired(np.concatenate([hashes[i - 3] + hashes[i - 2] for i in range(3)]))
    coplanar: list[Integers] = []
    blocks = (slice(k, k + _EDGES) for k in range(0, max(len(one), 1), _EDGES))
    parts = [_bent(points, normals, one[block], other[block], coplanar) for block in blocks]
    columns: dict[str, Any] = {name: np.concatenate([part.pop(name) for part in parts], axis=-1) for name in _COLUMNS}
    a, b = np.concatenate(coplanar, axis=1)
    flat = np.zeros(len(normals), dtype=np.bool_)
    flat[a] = flat[b] = True
    facet = components(len(normals), a, b)
    of_facets: Floats = np.bincount(facet, np.sqrt((normals * normals).sum(axis=1)) / 2).astype(np.float64)
    return BentEdges(**columns, flat=flat, facet=facet, areas=of_facets[facet])


def _bent(
    points: Floats, normals: Floats, one: Integers, other: Integers, coplanar: list[Integers]
) -> dict[str, Array]:
    """Return the columns of `BentEdges` of some edges; coplanar gets the pairs (2, n) of triangles in one plane.

    Args:
        points: (3 m, 3) by corner, then triangle. normals: (m, 3), as long as twice the areas.
    """
    count = len(normals)
    triangles = np.stack([one, other]) % count
    first, second = np.ascontiguousarray(normals.take(triangles, axis=0).transpose(0, 2, 1))
    cosine = first[0] * second[0] + first[1] * second[1] + first[2] * second[2]
    cross = np.stack([first[i - 2] * second[i - 1] - first[i - 1] * second[i - 2] for i in range(3)])
    sine = np.sqrt(cross[0] ** 2 + cross[1] ** 2 + cross[2] ** 2)
    coplanar.append(triangles[:, (sine <= BENT * cosine) & (cosine > 0)])
    angle = arctan2(sine, cosine)
    (kept,) = np.nonzero((angle > _FLAT) & (angle < _WIDEST))
    one, other = one[kept], other[kept]
    start, end = points.take(one, axis=0).T, points.take((one + count) % len(points), axis=0).T
    along = end - start
    length = np.sqrt(along[0] ** 2 + along[1] ** 2 + along[2] ** 2)
    angle = np.copysign(angle[kept], (cross[:, kept] * along).sum(axis=0))
    sides = np.stack([first[:, kept], second[:, kept]])
    sizes = np.sqrt((sides * sides).sum(axis=1))
    outward = np.stack([along[i - 2] * sides[:, i - 1] - along[i - 1] * sides[:, i - 2] for i in range(3)], axis=1)
    outward /= np.array([[1.0], [-1.0]])[:, None] * (sizes * length)[:, None]
    opposite = points.take(np.stack([one, other]) + 2 * count, axis=0, mode="wrap").transpose(2, 0, 1)
    feet = ((opposite - start[:, None]) * along[:, None]).sum(axis=0) / length**2
    found = (start, end, angle, length, sizes / length, feet, outward, triangles[:, kept])
    return dict(zip(_COLUMNS, found, strict=True))


_UNLIKE = 3
_UNPAIRED = 0.6
_SAME = 0.1


def endings(edges: BentEdges) -> Mask:
    """(2, k) whether the facet on each side ends at a sharp edge opposite to this one."""
    return _unpaired(edges, np.abs(edges.angle) > BENT) > _UNPAIRED


def opposed(edges: BentEdges, among: Mask) -> Mask:
    """(k,) whether the facets on both sides end opposite to this one at some of these edges, none of which is it."""
    found: Mask = np.all(_unpaired(edges, among) < -_UNPAIRED, axis=0)
    return found


def _unpaired(edges: BentEdges, among: Mask) -> Floats:
    """(2, k) what some edges of the facet on each side leave unpaired across this one, over its length.

    Lengths times outward vectors add up to zero around a facet: what some edges leave is what the others have.
    """
    facet = edges.facet[edges.triangles].ravel()
    weights = (edges.outward * np.where(among, edges.length, 0.0)).transpose(1, 0, 2).reshape(3, -1)
    left = np.stack([np.bincount(facet, one, len(edges.areas)) for one in weights])[:, facet].reshape(3, 2, -1)
    found: Floats = (left * edges.outward.transpose(1, 0, 2)).sum(axis=0) / edges.length
    return found


def companions(edges: BentEdges, among: Mask, either: bool = False) -> Floats:
    """(2, k) the largest angle at others of these edges of the facet on each side that bend the same way, else 0."""
    size = np.tile(np.where(among, np.abs(edges.angle), 0.0), 2)
    if not len(size):
        return np.zeros((2, 0))
    facet = 2 * edges.facet[edges.triangles].ravel() + (not either) * (np.tile(edges.angle, 2) < 0)
    largest, second = np.zeros((2, 2 * len(edges.areas)))
    np.maximum.at(largest, facet, size)
    top = size == largest[facet]
    np.maximum.at(second, facet, np.where(top, 0.0, size))
    only = top & (np.bincount(facet, top)[facet] == 1)
    found = np.where(only, second[facet], largest[facet])
    return found.reshape(2, -1)


def like(edges: BentEdges) -> Mask:
    """(k,) whether the facets on both sides are of the same kind, and not the plane that a fillet touches."""
    areas = edges.areas[edges.triangles]
    like: Mask = areas.max(axis=0) <= _UNLIKE * areas.min(axis=0)
    return like


def taper(edges: BentEdges) -> tuple[Floats, Floats]:
    """(k,) what is missing less where facets taper, and the doubt where heights differ.

    Between equal trapezoids of widths w1, w2 lacks l th (w1^2 + w1 w2 + w2^2) / 36, but the rule for heights says
    l th (w1^2 - w1 w2 + w2^2) / 12.
    """
    one, other = edges.areas[edges.triangles]
    differ = edges.length * edges.angle * (edges.heights[0] - edges.heights[1]) ** 2
    tapers = edges.flat[edges.triangles].all(axis=0) & (np.abs(one - other) <= _SAME * (one + other))
    uneven = np.where(like(edges), np.abs(differ) / 9, 0.0)
    return np.where(tapers, differ / 18, 0.0), np.where(tapers, uneven / 4, uneven)


def planes(edges: BentEdges, curved: Mask) -> Mask:
    """(2, k) which sides are planes that touch a fillet."""
    areas = edges.areas[edges.triangles]
    planes: Mask = (areas > _UNLIKE * areas[::-1]) & ~curved[edges.triangles]
    return planes


def sides(edges: BentEdges, plane: Mask) -> Floats:
    """(2, k) missing on either side."""
    heights = edges.heights
    volume = edges.length * edges.angle / 12
    even = volume * heights**3 / heights.sum(axis=0)
    return np.where(plane, 0.0, np.where(plane[::-1], volume * heights**2, even))
