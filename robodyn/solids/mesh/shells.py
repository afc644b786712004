"""Faces that add nothing dropped, rims put together, and connected shells, each wound in one way."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from robodyn.solids.mesh.indexed import Edges, Indexed, Mask, Numbers, components, distinct, numbered
from robodyn.solids.mesh.inside import winding_numbers
from robodyn.support.floats import Floats

_MOST_ANGLES = 50_000_000
"""Solid angles of faces that are taken to tell whether walls lie in bodies; where it takes more, they stay."""

_ROUNDING = 16 * np.finfo(np.float64).eps


def without_degenerate(mesh: Indexed) -> Indexed:
    """Return the mesh without its faces of exactly zero area.

    Faces between three different corners on a line stay where they close the surface along a seam.
    """
    a, b, c = mesh.faces.T
    mesh = mesh.keep((a != b) & (b != c) & (c != a))
    return mesh.keep(~_superfluous(mesh.faces, collinear(mesh.corners)))


def without_duplicates(mesh: Indexed) -> Indexed:
    """Return the mesh with one face of those between the same corners.

    Faces wound alike stay where one of them alone would open the surface: two bodies that are flush. Faces wound both
    ways are a wall between two bodies, or between a cavity and the insert that fills it, and go. But one of them stays
    if it is part of a surface that would be open without it, or of one that is given from both sides and lies in no
    other.
    """
    which, even = _corner_sets(mesh.faces)
    if which.max(initial=-1) + 1 == len(which):
        return mesh
    closed = not Edges.between(mesh.faces).balance.any()
    rows = np.flatnonzero(~_superfluous(mesh.faces, _ranks(2 * which + even) > 0, closed))
    which, even = which[rows], even[rows].astype(np.int64)
    ways = np.bincount(2 * which + even, minlength=2 * len(mesh.faces)).reshape(-1, 2)
    surplus = ways[which, even] - ways[which, 1 - even]
    wall = surplus == 0
    once = (_ranks(2 * which + even) < surplus) | (wall & (_ranks(which) == 0))
    rows, wall = rows[once], wall[once]
    stays = ~_superfluous(mesh.faces[rows], wall, closed)
    lone = rows[stays & wall]
    inside = _enclosed(mesh.keep(lone), mesh.keep(rows[~wall]))
    kept = np.concatenate([rows[stays & ~wall], lone[~inside]])
    return mesh.keep(np.sort(kept) if len(kept) else rows)


def _enclosed(walls: Indexed, others: Indexed) -> Mask:
    """(m,) which faces touch no others, but lie in what those enclose, told by one of each connected group."""
    found: Mask = np.zeros(len(walls.faces), np.bool_)
    if not len(walls.faces) or not len(others.faces):
        return found
    a, b, c = walls.faces.T
    group = components(len(walls.vertices), np.concatenate([a, a]), np.concatenate([b, c]))[a]
    _, first, of = np.unique(group, return_index=True, return_inverse=True)
    used = np.zeros(len(walls.vertices), np.bool_)
    used[others.faces] = True
    apart = np.flatnonzero(np.bincount(of, used[walls.faces].any(axis=1)) == 0)
    if 0 < len(apart) * len(others.faces) <= _MOST_ANGLES:
        winding = winding_numbers(walls.corners[first[apart]].mean(axis=1), others)
        found = np.isin(of, apart[np.abs(winding) > 0.5])
    return found


def _corner_sets(faces: Numbers) -> tuple[Numbers, Mask]:
    """(m,) the number of the set of corners of each face, and whether the corners, from the lowest on, go up."""
    most = int(faces.max(initial=0)) + 1
    low, middle, high = np.sort(faces, axis=1).T
    pair = distinct(low * most + middle).of
    which = distinct(pair * most + high).of
    turn = (faces.argmin(axis=1)[:, None] + np.arange(3)) % 3
    _, second, third = np.take_along_axis(faces, turn, axis=1).T
    return which, np.less(second, third)


def _ranks(names: Numbers) -> Numbers:
    """(m,) how often a name was there before."""
    rank, order = np.empty_like(names), np.argsort(names, kind="stable")
    rank[order] = np.arange(len(names)) - np.searchsorted(names[order], names[order])
    return rank


def collinear(corners: Floats) -> Mask:
    """(m,) whether the corners of each triangle lie on a line, decided without rounding."""
    a, b, c = corners.transpose(1, 0, 2)
    e, f = b - a, c - a
    size = np.linalg.norm(e, axis=1) * np.linalg.norm(f, axis=1)
    reach = np.abs(corners).max(axis=(1, 2)) * (np.abs(e) + np.abs(f)).max(axis=1)
    flat: Mask = np.linalg.norm(np.cross(e, f), axis=1) <= _ROUNDING * (size + reach)
    for row in np.flatnonzero(flat):
        flat[row] = _collinear_exactly(corners[row])
    return flat


def _collinear_exactly(triangle: Floats) -> bool:
    a, b, c = ([Fraction(x) for x in corner] for corner in triangle.tolist())
    e, f = [y - x for x, y in zip(a, b, strict=True)], [y - x for x, y in zip(a, c, strict=True)]
    return all(e[i - 2] * f[i - 1] == e[i - 1] * f[i - 2] for i in range(3))


def _superfluous(faces: Numbers, doubtful: Mask, directed: bool = False) -> Mask:
    """(m,) which of the doubtful faces leave no more edges with an odd number of faces if they go.

    This is decided for each connected group of them; one that touches no other face stays if it is closed.

    Args:
        directed: it is by how much more often edges are passed one way than the other that counts.
    """
    rows = np.flatnonzero(doubtful)
    if not rows.size:
        return doubtful
    edges = Edges.between(faces)
    own = edges.of[rows]
    most = len(edges.count)
    nodes = np.repeat(np.arange(len(rows)), 3)
    group = components(len(rows) + most, nodes, len(rows) + own.ravel())[: len(rows)]
    others = edges.count - np.bincount(own.ravel(), minlength=most)
    open_now, open_then = edges.count % 2, others % 2
    if directed:
        lost = np.bincount(own.ravel(), edges.way[rows].ravel(), most).astype(np.int64)
        open_now, open_then = np.abs(edges.balance), np.abs(edges.balance - lost)
    touched, first = np.unique(own, return_index=True)
    of_edge = np.repeat(group, 3)[first]
    groups = int(group.max()) + 1
    stays = np.bincount(of_edge, open_now[touched], groups)
    goes = np.bincount(of_edge, open_then[touched], groups)
    near = np.bincount(of_edge, others[touched] > 0, groups)
    found = np.zeros_like(doubtful)
    found[rows] = ((goes < stays) | ((goes == stays) & (near > 0)))[group]
    return found


@dataclass(frozen=True, eq=False)
class Shells:
    """A mesh in parts that are connected over edges.

    Attributes:
        mesh: all of it.
        label: (m,) the shell of each face.
        closed: (k,) whether the boundary of each shell vanishes.
        rim: (b, 3) the shell, the start and the end of each edge that is missing to close it, in this order of shells
            and of edges.
        twisted: faces of patches that have one side only, like a Moebius strip, and so no winding.
    """

    mesh: Indexed
    label: Numbers
    closed: Mask
    rim: Numbers
    twisted: int = 0

    @property
    def count(self) -> int:
        return len(self.closed)


def wound(mesh: Indexed) -> tuple[Shells, int]:
    """Return the shells with faces turned so that neighbours agree, and how many were turned.

    Neighbours are the two faces on an edge that has no others, in a patch those that such edges connect. The fewer
    faces of a patch are turned. Patches that are closed are shells; they are set aside, which leaves fewer faces on
    edges with more than two, until none is found. What then remains is put together wherever it shares an edge.
    """
    label = np.full(len(mesh.faces), -1, np.int64)
    turned = np.zeros(len(mesh.faces), np.bool_)
    rows = np.arange(len(mesh.faces))
    shells = 0
    while rows.size:
        edges = Edges.between(mesh.faces[rows])
        patch, turn, twisted = _patches(edges, len(rows))
        done = _closed(edges, patch, turn, twisted)
        turned[rows] = turn
        count, found = numbered(patch[done[patch]], len(done))
        label[rows[done[patch]]] = shells + found
        shells += count
        if not count or done.all():
            break
        rows = rows[~done[patch]]
    open_rows = np.flatnonzero(label < 0)
    closed, rim, one_sided = np.ones(shells, np.bool_), np.zeros((0, 3), np.int64), 0
    if open_rows.size:
        count, rest = _over_edges(edges)
        label[open_rows] = shells + rest
        closed = np.append(closed, np.zeros(count, np.bool_))
        rim = _rim(edges, turn, label[open_rows])
        one_sided = int(twisted[patch].sum())
    return Shells(mesh.turned(turned), label, closed, rim, one_sided), int(turned.sum())


def _patches(edges: Edges, faces: int) -> tuple[Numbers, Mask, Mask]:
    """Return the patch of each face, whether to turn it, and which patches have one side only.

    A component of the graph in which every face stands twice, once for each winding.
    """
    a, b, alike = edges.pairs()
    swapped = np.where(alike, 0, faces)
    sides = components(2 * faces, np.concatenate([a, a + faces]), np.concatenate([b + swapped, b + faces - swapped]))
    given, reverse = sides[:faces], sides[faces:]
    lower = np.minimum(given, reverse)
    count, patch = numbered(lower, 2 * faces)
    other = (given != lower).astype(np.int64)
    size = np.bincount(patch, minlength=count)
    swap = 2 * np.bincount(patch, other, count) > size
    twisted = np.zeros(count, np.bool_)
    twisted[patch[given == reverse]] = True
    turn: Mask = ((other == 1) ^ swap[patch]) & ~twisted[patch]
    return patch, turn, twisted


def _closed(edges: Edges, patch: Numbers, turn: Mask, twisted: Mask) -> Mask:
    """Return which patches have no boundary: on edges of other than two faces their sides must cancel."""
    side = np.flatnonzero(edges.count[edges.of.ravel()] != 2)
    face = side // 3
    way = np.where(turn[face], -1, 1) * edges.way.ravel()[side]
    keys, place = np.unique(patch[face] * len(edges.count) + edges.of.ravel()[side], return_inverse=True)
    unbalanced = keys[np.bincount(place, way, len(keys)) != 0] // len(edges.count)
    closed = ~twisted
    closed[unbalanced] = False
    return closed


def _rim(edges: Edges, turn: Mask, label: Numbers) -> Numbers:
    """Return what is missing to close shells that share no edge, see `Shells`."""
    edge, ends = replace(edges, way=np.where(turn[:, None], -edges.way, edges.way)).boundary()
    of_edge = np.empty(len(edges.count), np.int64)
    of_edge[edges.of] = label[:, None]
    rows = np.column_stack((of_edge[edge], ends))
    found: Numbers = rows[np.argsort(rows[:, 0], kind="stable")]
    return found


def _over_edges(edges: Edges) -> tuple[int, Numbers]:
    """Return how many components faces have over any edge, and (m,) that of each."""
    faces, most = len(edges.of), len(edges.of) + len(edges.count)
    nodes = np.repeat(np.arange(faces), 3)
    return numbered(components(most, nodes, faces + edges.of.ravel())[:faces], most)


_NEAR = 1e-6
"""Distance of corners that rounding may have parted, over the size of the surface."""


def one_sided(shells: Shells) -> int:
    """Return how many faces are in surfaces that cannot be wound, whose inside and outside are not told apart.

    Of open ones corners on the rims are made one where rounding may have parted them: caps on the rims of a Klein
    bottle would give it two sides.
    """
    rim = np.unique(shells.rim[:, 1:])
    if not rim.size:
        return shells.twisted
    points, faces = shells.mesh.vertices, shells.mesh.faces
    places = np.rint(points[rim] / (_NEAR * np.ptp(points[faces], axis=(0, 1)).max()))
    _, first, of = np.unique(places, axis=0, return_index=True, return_inverse=True)
    name = np.arange(len(points))
    name[rim] = rim[first[of.ravel()]]
    a, b, c = name[faces].T
    whole = Indexed(points, name[faces][(a != b) & (b != c) & (c != a)])
    return wound(whole)[0].twisted if len(first) < len(rim) else shells.twisted
