"""Holes in shells, filled where they are small."""

from __future__ import annotations

from dataclasses import dataclass, replace
from heapq import heapify, heappop, heappush

import numpy as np

from robodyn.mesh.indexed import Edges, Numbers, areas
from robodyn.mesh.shells import Shells
from robodyn.mesh.triangles import Floats

LARGEST_OF_SHELL = 0.1
"""Share of a shell that may be missing: a box without one of its 12 triangles is filled, without a side it is not."""

LARGEST_OF_ALL = 0.01
"""Share of the whole surface that what is missing from a shell may have, however open that shell is."""

_SEAM = 1e-6
"""Area over squared perimeter below which a gap is a seam: a T-junction, or an edge drawn twice."""


@dataclass(frozen=True)
class Filling:
    """What became of the gaps.

    Attributes:
        shells: with the filled ones closed.
        holes, seams: gaps that were filled; a seam has no area to speak of.
        triangles: that fill them. area: of these.
        left: gaps of shells that stay open, too large to be filled.
        missing: the share of the surface, of those shells with their gaps filled, that is missing.
    """

    shells: Shells
    holes: int = 0
    seams: int = 0
    triangles: int = 0
    area: float = 0.0
    left: int = 0
    missing: float = 0.0


def filled(shells: Shells) -> Filling:
    """Fill the boundary loops of open shells, unless they are large.

    The boundary of a surface is made of loops, each of which is cut into triangles without new corners. Where a loop is
    plane the moments of what it then encloses do not depend on how it is cut.
    """
    mesh = shells.mesh
    total = float(mesh.areas.sum())
    own = np.bincount(shells.label, mesh.areas, shells.count)
    closed, found = shells.closed.copy(), Filling(shells)
    patches, labels = [mesh.faces], [shells.label]
    open_area = missing = 0.0
    for shell in np.flatnonzero(~shells.closed):
        caps = [_cap(mesh.vertices, loop) for loop in _loops(shells.faces(int(shell)))]
        sizes = [float(areas(mesh.vertices[cap]).sum()) for cap in caps]
        gap = sum(sizes)
        if gap > max(LARGEST_OF_SHELL * (gap + own[shell]), LARGEST_OF_ALL * total):
            found = replace(found, left=found.left + len(caps))
            open_area, missing = open_area + float(own[shell]), missing + gap
            continue
        seams = sum(_is_seam(mesh.vertices, cap, size) for cap, size in zip(caps, sizes, strict=True))
        found = replace(
            found,
            holes=found.holes + len(caps) - seams,
            seams=found.seams + seams,
            triangles=found.triangles + sum(map(len, caps)),
            area=found.area + gap,
        )
        patches += caps
        labels += [np.full(len(cap), shell, np.int64) for cap in caps]
        closed[shell] = True
    whole = replace(mesh, faces=np.concatenate(patches))
    after = replace(shells, mesh=whole, label=np.concatenate(labels), closed=closed)
    return replace(found, shells=after, missing=missing / (missing + open_area) if missing else 0.0)


def _loops(faces: Numbers) -> list[list[int]]:
    """The boundary as loops of vertices that pass none twice, in the direction that triangles filling them have."""
    edges = Edges.between(faces)
    balance = edges.balance
    onward: dict[int, list[int]] = {}
    for (a, b), excess in zip(edges.ends[balance != 0].tolist(), balance[balance != 0].tolist(), strict=True):
        start, stop = (b, a) if excess > 0 else (a, b)
        onward.setdefault(start, []).extend([stop] * abs(excess))
    loops = []
    for begin in onward:
        path, place = [begin], {begin: 0}
        while onward.get(path[-1]):
            step = onward[path[-1]].pop()
            if step in place:
                loops.append(path[place[step] :])
                for vertex in path[place[step] + 1 :]:
                    del place[vertex]
                del path[place[step] + 1 :]
            else:
                place[step] = len(path)
                path.append(step)
    return loops


def _cap(vertices: Floats, loop: list[int]) -> Numbers:
    """(n - 2, 3) triangles within a loop of n vertices: again and again the corner with the shortest side opposite."""
    points = dict(zip(loop, vertices[loop], strict=True))
    before = dict(zip(loop, [loop[-1], *loop[:-1]], strict=True))
    after = {vertex: follower for follower, vertex in before.items()}

    def ear(vertex: int) -> tuple[float, int, int, int]:
        a, c = before[vertex], after[vertex]
        return float(np.linalg.norm(points[c] - points[a])), vertex, a, c

    queue = [ear(vertex) for vertex in loop]
    heapify(queue)
    found: list[tuple[int, int, int]] = []
    while len(found) < len(loop) - 2:
        _, vertex, a, c = heappop(queue)
        if before.get(vertex) != a or after.get(vertex) != c:
            continue
        found.append((a, vertex, c))
        del before[vertex], after[vertex]
        after[a], before[c] = c, a
        heappush(queue, ear(a))
        heappush(queue, ear(c))
    return np.array(found, np.int64).reshape(-1, 3)


def _is_seam(vertices: Floats, cap: Numbers, area: float) -> bool:
    edges = Edges.between(cap)
    ends = edges.ends[edges.count == 1]
    around = float(np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1).sum())
    return area <= _SEAM * around**2
