"""Faces that add nothing dropped, rims put together, and connected shells, each wound in one way."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from robodyn.solids.inertia.laws import exact
from robodyn.solids.mesh.indexed import Edges, Indexed, Mask, Numbers, components, numbered
from robodyn.solids.mesh.inside import winding_numbers
from robodyn.support.floats import Floats

_MOST_COPIES = 32
_MOST_ANGLES = 50_000_000
"""Solid angles of faces that are taken to tell whether walls lie in bodies; where it takes more, they stay."""
_ROUNDING = 16 * np.finfo(np.float64).eps
_NEAR = 1e-6
"""Distance of corners that rounding may have parted, over the size of the surface."""
_CELL = 4.0
"""Times this distance, the side of the cells in which near corners are sought."""


def without_degenerate(mesh: Indexed) -> Indexed:
    """Return the mesh without its faces of exactly zero area, but for those that close it along a seam."""
    a, b, c = mesh.faces.T
    mesh = mesh.keep((a != b) & (b != c) & (c != a))
    return mesh.keep(~_superfluous(mesh.faces, collinear(mesh.corners), alone=True))


def without_duplicates(mesh: Indexed) -> tuple[Indexed, Numbers]:
    """Return the mesh with one face of those between the same corners, and (m,) for how many wound alike each stands.

    Faces wound alike stay where one of them alone would open the surface: two bodies that are flush. Faces wound both
    ways cancel: a wall between two bodies, or an insert in its cavity. But one stays where the surface would be open
    without it, or if nothing else is near or around it: a surface that is given from both sides.
    """
    # (m,) the number of the set of corners of each face, and whether the corners, from the lowest on, go up
    most = int(mesh.faces.max(initial=0)) + 1
    low, middle, high = np.sort(mesh.faces, axis=1).T
    _, pair = np.unique(low * most + middle, return_inverse=True)
    _, which = np.unique(pair * most + high, return_inverse=True)
    turn = (mesh.faces.argmin(axis=1)[:, None] + np.arange(3)) % 3
    _, second, third = np.take_along_axis(mesh.faces, turn, axis=1).T
    even = np.less(second, third)
    sets = int(which.max(initial=-1)) + 1
    if sets == len(which):
        return mesh, np.ones(sets, np.int64)
    sided = 2 * which + even
    copies = np.bincount(sided, minlength=2 * sets)
    # some of faces wound alike that are given very often, an odd number of them if they are an odd number
    few = np.where(copies > _MOST_COPIES, _MOST_COPIES - (copies - _MOST_COPIES) % 2, copies)
    rows = np.flatnonzero(_ranks(sided, copies) < few[sided])
    rows = rows[~_superfluous(mesh.faces[rows], ~_first_of(sided[rows]), alone=True)]
    if Edges.between(mesh.faces).balance.any():
        copies[:] = 1
    else:
        copies //= np.maximum(np.bincount(sided[rows], minlength=2 * sets), 1)
        count = np.bincount(sided[rows], minlength=2 * sets)
        ways = count.reshape(-1, 2)
        pairs = ways.min(axis=1) - (ways[:, 0] == ways[:, 1])  # that cancel, but for the last two
        rows = rows[_ranks(sided[rows], count) >= pairs[which[rows]]]
    both: Mask = np.logical_and(*(np.bincount(sided[rows], minlength=2 * sets).reshape(-1, 2).T > 0))[which]
    surplus = (copies[1::2] - copies[::2])[which]
    often = np.where(both, np.abs(surplus), copies[sided])
    more = np.where(surplus[rows] == 0, _first_of(which[rows]), even[rows] == (surplus[rows] > 0))
    rows = rows[~both[rows] | more]
    rows = rows[~_superfluous(mesh.faces[rows], both[rows], alone=False)]
    within = _enclosed(mesh.keep(rows), often[rows])
    rows = rows[~_superfluous(mesh.faces[rows], within, alone=True)]
    return mesh.keep(rows), np.maximum(often[rows], 1)


def _enclosed(mesh: Indexed, copies: Numbers) -> Mask:
    """(m,) which of the faces that count for nothing lie in what all others enclose, told for each connected group."""
    found: Mask = copies == 0
    others = mesh.keep(np.repeat(np.arange(len(copies)), copies))
    if found.any() and len(others.faces):
        a, b, c = mesh.faces[found].T
        group = components(len(mesh.vertices), np.concatenate([a, a]), np.concatenate([b, c]))[a]
        _, first, of = np.unique(group, return_index=True, return_inverse=True)
        if len(first) * len(others.faces) > _MOST_ANGLES:
            return np.zeros_like(found)
        found[found] = (np.abs(winding_numbers(mesh.corners[found][first].mean(axis=1), others)) > 0.5)[of]
        return found
    return np.zeros_like(found)


def _ranks(names: Numbers, count: Numbers) -> Numbers:
    """(m,) how often a name was there before; count: of each name."""
    rank, order = np.empty_like(names), np.argsort(names, kind="stable")
    rank[order] = np.arange(len(names)) - (np.cumsum(count) - count)[names[order]]
    return rank


def _first_of(names: Numbers) -> Mask:
    first: Mask = np.zeros(len(names), np.bool_)
    first[np.unique(names, return_index=True)[1]] = True
    return first


def collinear(corners: Floats) -> Mask:
    """(m,) whether the corners of each triangle lie on a line, decided without rounding."""
    a, b, c = corners.transpose(1, 0, 2)
    e, f = b - a, c - a
    size = np.linalg.norm(e, axis=1) * np.linalg.norm(f, axis=1)
    reach = np.abs(corners).max(axis=(1, 2)) * (np.abs(e) + np.abs(f)).max(axis=1)
    flat: Mask = np.linalg.norm(np.cross(e, f), axis=1) <= _ROUNDING * (size + reach)
    for row in np.flatnonzero(flat):
        a, b, c = exact(corners[row])
        flat[row] = not np.cross(b - a, c - a).any()
    return flat


def _superfluous(faces: Numbers, doubtful: Mask, alone: bool) -> Mask:
    """(m,) which of the doubtful faces leave no more edges with an odd number of faces if they go, by connected groups;
    alone: whether a group that touches no other face goes."""
    rows = np.flatnonzero(doubtful)
    if not rows.size:
        return doubtful
    edges = Edges.between(faces)
    own = edges.of[rows]
    most = len(edges.count)
    nodes = np.repeat(np.arange(len(rows)), 3)
    group = components(len(rows) + most, nodes, len(rows) + own.ravel())[: len(rows)]
    within = np.bincount(own.ravel(), minlength=most)
    others = edges.count - within
    touched, first = np.unique(own, return_index=True)
    of_edge = np.repeat(group, 3)[first]
    groups = int(group.max()) + 1
    stays = np.bincount(of_edge, (within + others)[touched] % 2, groups)
    goes = np.bincount(of_edge, others[touched] % 2, groups)
    near = np.bincount(of_edge, others[touched] > 0, groups)
    found = np.zeros_like(doubtful)
    found[rows] = ((goes <= stays) & (alone | (near > 0)))[group]
    return found


def welded(mesh: Indexed, rim: Numbers) -> Indexed:
    """The mesh with corners on its rims (v,) made one where rounding may have parted them, without faces that vanish.
    The same object where there are none. Corners within 1e-6 of the surface's size share a cell of at least one of
    eight lattices, shifted by half a cell."""
    used = np.zeros(len(mesh.vertices), np.bool_)
    used[mesh.faces] = True
    points = mesh.vertices[rim]
    cell = _CELL * _NEAR * float(np.ptp(mesh.vertices[used], axis=0).max())
    if not len(rim) or not cell > 0:
        return mesh
    links = []
    for shift in product((0.0, 0.5), repeat=3):
        cells = np.floor(points / cell + shift)
        order = np.lexsort(cells.T)
        same = (np.diff(cells[order], axis=0) == 0).all(axis=1)
        links.append(np.stack([order[:-1][same], order[1:][same]]))
    label = components(len(rim), *np.concatenate(links, axis=1))
    _, first = np.unique(label, return_index=True)
    if len(first) == len(rim):
        return mesh
    name = np.arange(len(mesh.vertices))
    name[rim] = rim[first[label]]
    a, b, c = faces = name[mesh.faces].T
    return replace(mesh, faces=faces.T[(a != b) & (b != c) & (c != a)])


@dataclass(frozen=True, eq=False)
class Shells:
    """A mesh in parts that are connected over edges.

    label: (m,) the shell of each face; closed: (k,) whether the boundary of each vanishes; rim: (b, 3) shell, start and
    end of each edge that is missing to close it, in order; lone: (v,) vertices of edges with one face, when shells were
    wound; twisted: faces of patches that have one side only, like a Moebius strip.
    """

    mesh: Indexed
    label: Numbers
    closed: Mask
    rim: Numbers
    lone: Numbers
    twisted: int = 0

    @property
    def count(self) -> int:
        return len(self.closed)


def wound(mesh: Indexed) -> tuple[Shells, int]:
    """Return the shells with faces turned so that neighbours agree, and how many were turned.

    Neighbours are the two faces on an edge that has no others; such edges connect patches, of which the fewer faces are
    turned. Closed patches are shells; they are set aside, which leaves fewer faces on edges with more than two, until
    none is found. What then remains is put together wherever it shares an edge.
    """
    label = np.full(len(mesh.faces), -1, np.int64)
    turned = np.zeros(len(mesh.faces), np.bool_)
    rows = np.arange(len(mesh.faces))
    shells, lone = 0, np.zeros(0, np.int64)
    while rows.size:
        edges = Edges.between(mesh.faces[rows])
        lone = lone if shells else np.unique(edges.ends[edges.count == 1])
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
        faces, most = len(edges.of), len(edges.of) + len(edges.count)
        over_edges = components(most, np.repeat(np.arange(faces), 3), faces + edges.of.ravel())[:faces]
        count, rest = numbered(over_edges, most)
        label[open_rows] = shells + rest
        closed = np.append(closed, np.zeros(count, np.bool_))
        edge, ends = replace(edges, way=np.where(turn[:, None], -edges.way, edges.way)).boundary()
        of_edge = np.empty(len(edges.count), np.int64)
        of_edge[edges.of] = label[open_rows, None]
        rim = np.column_stack((of_edge[edge], ends))
        rim = rim[np.argsort(rim[:, 0], kind="stable")]
        one_sided = int(twisted[patch].sum())
    return Shells(mesh.turned(turned), label, closed, rim, lone, one_sided), int(turned.sum())


def _patches(edges: Edges, faces: int) -> tuple[Numbers, Mask, Mask]:
    """Return the patch of each face, whether to turn it, and which patches have one side only. A component of the graph
    in which every face stands twice, once for each winding."""
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
