"""Caps of many rims at once, each near what it closes."""

from __future__ import annotations

import numpy as np

from robodyn.solids.mesh.indexed import Edges, Indexed, Numbers
from robodyn.solids.mesh.region.winding_tree import clusters
from robodyn.solids.mesh.triangles import Floats

_GROUP = 12
"""Edges that are closed from one vertex, at most."""

_FAN = 512
"""Triangles around one vertex from which on they are replaced."""


def local_caps(mesh: Indexed) -> Indexed:
    """Triangles with the same boundary, where many of them share a vertex.

    Edges of the boundary that lie together are closed from a vertex amid them, and where two such groups meet, by a
    triangle with both of their vertices. What is then left to close is a polygon through those vertices, in which what
    goes to and fro, along rims of patches that nearly meet, is gone; it is closed in the same way.
    """
    apex = int(np.argmax(np.bincount(mesh.faces.ravel()))) if len(mesh.faces) else 0
    fan = (mesh.faces == apex).any(axis=1)
    if np.count_nonzero(fan) <= _FAN:
        return mesh
    found = [mesh.faces[~fan]]
    rim = _boundary(mesh.faces[fan])
    last = len(rim) + 1
    while _GROUP < len(rim) < last:
        last = len(rim)
        *closing, rim = _closed(mesh.vertices, rim)
        found += closing
    found.append(np.column_stack([rim, np.repeat(rim[:1, 0], len(rim))]))
    faces = np.concatenate(found)
    a, b, c = faces.T
    return Indexed(mesh.vertices, faces[(a != b) & (b != c) & (c != a)])


def _boundary(faces: Numbers) -> Numbers:
    """(n, 2) directed edges, as often as they are left over."""
    edges = Edges.between(faces)
    return _uncancelled(edges.ends, edges.balance)


def _uncancelled(ends: Numbers, balance: Numbers) -> Numbers:
    way = np.where(balance[:, None] > 0, ends, ends[:, ::-1])
    return np.repeat(way, np.abs(balance), axis=0)


def _closed(vertices: Floats, rim: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    """Triangles on the edges of a rim, those where groups of them meet, and the rim (n, 2) that these leave."""
    middle = vertices[rim].mean(axis=1)
    amid = np.empty(len(rim), np.int64)
    for group in clusters(middle, _GROUP):
        ends = rim[group, 0]
        amid[group] = ends[np.argmin(((vertices[ends] - middle[group].mean(axis=0)) ** 2).sum(axis=1))]
    into, out = np.lexsort((amid, rim[:, 1])), np.lexsort((amid, rim[:, 0]))
    joints = np.column_stack([amid[into], rim[into, 1], amid[out]])
    joints = joints[joints[:, 0] != joints[:, 2]]
    steps = joints[:, [0, 2]]
    low, high = steps.min(axis=1), steps.max(axis=1)
    keys, of = np.unique(low * len(vertices) + high, return_inverse=True)
    balance = np.bincount(of.ravel(), np.where(steps[:, 0] == low, 1, -1), len(keys)).astype(np.int64)
    ends = np.column_stack([keys // len(vertices), keys % len(vertices)])
    return np.column_stack([rim, amid]), joints, _uncancelled(ends, balance)
