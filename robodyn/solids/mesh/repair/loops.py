"""The boundary of an open surface: loops, and triangles that close them."""

from __future__ import annotations

from heapq import heapify, heappop, heappush

import numpy as np

from robodyn.programs.vectors import length
from robodyn.solids.mesh.indexed import Edges, Numbers
from robodyn.solids.mesh.triangles import Floats

_SEAM = 1e-6
"""Area over squared perimeter below which a gap is a seam: a T-junction, or an edge drawn twice."""


def boundary_loops(faces: Numbers) -> list[list[int]]:
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


def cap_of(vertices: Floats, loop: list[int]) -> Numbers:
    """(n - 2, 3) triangles within a loop of n vertices: again and again the corner with the shortest side opposite."""
    points = dict(zip(loop, vertices[loop], strict=True))
    before = dict(zip(loop, [loop[-1], *loop[:-1]], strict=True))
    after = {vertex: follower for follower, vertex in before.items()}

    def ear(vertex: int) -> tuple[float, int, int, int]:
        a, c = before[vertex], after[vertex]
        return length(points[c] - points[a]), vertex, a, c

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


def is_seam(vertices: Floats, cap: Numbers, area: float) -> bool:
    """Return whether a cap (n, 3) of this area is next to nothing: where surfaces should meet but do not quite."""
    edges = Edges.between(cap)
    ends = edges.ends[edges.count == 1]
    around = float(np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1).sum())
    return area <= _SEAM * around**2
