"""Triangles as numbers of vertices, equal points made one, the edges that triangles share, connected components."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats, einsum

Numbers = NDArray[np.signedinteger[Any]]
Words = NDArray[np.uint64]

_FACTORS = tuple(map(np.uint64, (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)))
_HALF = np.uint64(32)
Mask = NDArray[np.bool_]


def paired(keys: Words) -> tuple[Numbers, Numbers]:
    """Return the places at which keys are that exactly two have: the first of each key, ascending, and the second."""
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    same = np.concatenate([[False], ordered[1:] == ordered[:-1], [False]])
    (begin,) = np.nonzero(~same[:-2] & same[1:-1] & ~same[2:])
    one, other = order[begin], order[begin + 1]
    order = np.argsort(one)
    return one[order], other[order]


def numbered(names: Numbers, most: int) -> tuple[int, Numbers]:
    """Return how many different names (n,) from 0 to most - 1 there are, and the number of each in their order."""
    there = np.zeros(most, np.bool_)
    there[names] = True
    number = np.cumsum(there)
    return int(number[-1]) if most else 0, number[names] - 1


def hashed(X: Floats) -> Words:
    """(k, m) of points (k, 3 coordinates, m), mixed so well that the sums for sides of a rectangle differ."""
    bits = (X + 0.0).view(np.uint64)
    words: Words = bits[:, 0] * _FACTORS[0]
    for i in (1, 2):
        words ^= words >> _HALF
        words += bits[:, i]
        words *= _FACTORS[i]
    for factor in _FACTORS[:2]:
        words ^= words >> _HALF
        words *= factor
    words ^= words >> _HALF
    return words


@dataclass(frozen=True, eq=False)
class Indexed:
    """Vertices (v, 3), all different, and faces (m, 3) of their numbers."""

    vertices: Floats
    faces: Numbers

    @property
    def corners(self) -> Floats:
        """(m, 3, 3)."""
        return self.vertices[self.faces]

    def corners_with(self, more: Numbers) -> Floats:
        """(m + n, 3, 3) with these faces (n, 3) as the last."""
        return replace(self, faces=np.concatenate([self.faces, more])).corners

    @property
    def middle(self) -> Floats:
        """(3,) of the box of all vertices."""
        centre: Floats = self.vertices.min(axis=0) / 2 + self.vertices.max(axis=0) / 2
        return centre

    def volume(self, reference: Floats) -> float:
        """Return the signed integral of 1, about a point (3,) that matters only if the surface is open."""
        return float(triple(self.corners - reference).sum() / 6)

    def keep(self, chosen: Mask | Numbers) -> Indexed:
        return replace(self, faces=self.faces[chosen])

    def turned(self, chosen: Mask) -> Indexed:
        """These faces wound the other way."""
        return replace(self, faces=np.where(chosen[:, None], self.faces[:, ::-1], self.faces))


def merged(corners: Floats) -> Indexed:
    """Triangles (m, 3, 3) with corners of equal coordinates made one vertex, by x, then y, then z; -0 is 0."""
    points = corners.reshape(-1, 3) + 0.0
    order = np.lexsort(points.T[::-1])
    ordered = points[order]
    new = np.ones(len(points), np.bool_)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    number = np.empty(len(points), np.int64)
    number[order] = np.cumsum(new) - 1
    return Indexed(ordered[new], number.reshape(-1, 3))


def triple(corners: Floats) -> Floats:
    """(m,) a . (b x c) of the corners of each triangle."""
    a, b, c = corners.transpose(1, 0, 2)
    products: Floats = einsum("ij,ij->i", a, np.cross(b - a, c - a))
    return products


def areas(corners: Floats) -> Floats:
    """(m,) of triangles (m, 3, 3)."""
    a, b, c = corners.transpose(1, 0, 2)
    found: Floats = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    return found


def in_parts(corners: Floats, label: Numbers) -> tuple[list[Floats], Floats, Floats]:
    """Triangles (m, 3, 3) by their labels, ascending from 0, and the least and largest coordinates (k, 3) of each."""
    order = np.argsort(label, kind="stable")
    starts = np.flatnonzero(np.diff(label[order], prepend=-1))
    corners = corners[order]
    lo, hi = np.minimum.reduceat(corners.min(axis=1), starts), np.maximum.reduceat(corners.max(axis=1), starts)
    return np.split(corners, starts[1:]), lo, hi


@dataclass(frozen=True, eq=False)
class Edges:
    """Which sides of triangles lie on the same edge; side k goes from corner k to the next.

    ends: (e, 2) vertices, the lower number first; of: (m, 3) the edge of each side; way: (m, 3) 1 where it goes from
    the lower number to the higher, otherwise -1; count: (e,) sides on each edge.
    """

    ends: Numbers
    of: Numbers
    way: Numbers
    count: Numbers

    @classmethod
    def between(cls, faces: Numbers) -> Edges:
        start, stop = faces, np.roll(faces, -1, axis=1)
        lower, higher = np.minimum(start, stop), np.maximum(start, stop)
        most = int(faces.max(initial=0)) + 1
        _, first, of = np.unique((lower * most + higher).ravel(), return_index=True, return_inverse=True)
        ends = np.stack([lower.ravel()[first], higher.ravel()[first]], axis=1)
        return cls(ends, of.reshape(-1, 3), np.where(start < stop, 1, -1), np.bincount(of, minlength=len(first)))

    @property
    def balance(self) -> Numbers:
        """(e,) how many more sides go up than down: not zero on the boundary."""
        total: Numbers = np.bincount(self.of.ravel(), self.way.ravel(), len(self.count)).astype(np.int64)
        return total

    def boundary(self) -> tuple[Numbers, Numbers]:
        """(b,) edges on the boundary, as often as they are, and (b, 2) vertices as faces that fill it pass them."""
        balance = self.balance
        edge = np.repeat(np.arange(len(balance)), np.abs(balance))
        return edge, np.where(balance[edge, None] > 0, self.ends[edge, ::-1], self.ends[edge])

    def pairs(self) -> tuple[Numbers, Numbers, Mask]:
        """The two faces on each edge of exactly two, and whether they are wound alike (pass it opposite ways)."""
        two = self.count == 2
        sides = np.flatnonzero(two[self.of.ravel()])
        edge = self.of.ravel()[sides]
        ends = np.empty((2, len(two)), np.int64)
        ends[0, edge[::-1]], ends[1, edge] = sides[::-1], sides
        first, second = ends[:, two]
        way = self.way.ravel()
        return first // 3, second // 3, way[first] != way[second]


def components(count: int, a: Numbers, b: Numbers) -> Numbers:
    """(count,) the number of the connected component of each node of a graph with the links a[i] to b[i]. Components
    are numbered as their first nodes are. Every node with links to lower ones is hooked to the lowest of them and then
    to the root of that; the roots are nodes of a smaller graph (Boruvka's contraction)."""
    label = np.arange(count)
    nodes = count
    while True:
        apart = a != b
        a, b = a[apart], b[apart]
        if not a.size:
            return label
        parent = np.arange(nodes)
        np.minimum.at(parent, np.maximum(a, b), np.minimum(a, b))
        number = np.cumsum(parent == np.arange(nodes)) - 1
        while not np.array_equal(further := parent[parent], parent):
            parent = further
        step = number[parent]
        label, a, b = step[label], step[a], step[b]
        nodes = int(number[-1]) + 1
