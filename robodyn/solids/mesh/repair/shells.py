"""The connected shells of a mesh, each wound in one way."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robodyn.solids.mesh.distinct import Numbers, numbered
from robodyn.solids.mesh.indexed import Edges, Indexed, Mask, components


@dataclass(frozen=True, eq=False)
class Shells:
    """A mesh in parts that are connected over edges.

    Attributes:
        mesh: all of it.
        label: (m,) the shell of each face.
        closed: (k,) whether the boundary of each shell vanishes.
        rim: (b, 3) the shell, the start and the end of each edge that is missing to close it, in this order of shells
            and of edges.
        lone: (v,) vertices of edges with one face, when shells were wound.
        twisted: faces of patches that have one side only, like a Moebius strip, and so no winding.
    """

    mesh: Indexed
    label: Numbers
    closed: Mask
    rim: Numbers
    lone: Numbers
    twisted: int = 0

    @property
    def tangled(self) -> bool:
        """Whether there are some that have no boundary, but edges of so many faces that their sides cannot be told."""
        return len(np.setdiff1d(np.flatnonzero(~self.closed), self.rim[:, 0])) > 0

    @property
    def count(self) -> int:
        return len(self.closed)

    def faces(self, shell: int) -> Numbers:
        """Return the faces (n, 3) of a shell."""
        chosen: Numbers = self.mesh.faces[self.label == shell]
        return chosen


def wound(mesh: Indexed) -> tuple[Shells, int]:
    """Return the shells with faces turned so that neighbours agree, and how many were turned.

    Neighbours are the two faces on an edge that has no others, in a patch those that such edges connect. The fewer
    faces of a patch are turned. Patches that are closed are shells; they are set aside, which leaves fewer faces on
    edges with more than two, until none is found. What then remains is put together wherever it shares an edge.
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
        count, rest = _over_edges(edges)
        label[open_rows] = shells + rest
        closed = np.append(closed, np.zeros(count, np.bool_))
        rim = _rim(edges, turn, label[open_rows])
        one_sided = int(twisted[patch].sum())
    return Shells(mesh.turned(turned), label, closed, rim, lone, one_sided), int(turned.sum())


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
