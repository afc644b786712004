"""Holes in shells: the loops around them, triangles that close them, which are filled, and what stays open."""

from __future__ import annotations

from dataclasses import dataclass, replace
from heapq import heapify, heappop, heappush
from math import sqrt
from typing import NamedTuple

import numpy as np

from robodyn.solids.mesh.indexed import Numbers, areas, merged
from robodyn.solids.mesh.shells import Shells, welded, without_degenerate, without_duplicates, wound
from robodyn.solids.mesh.triangles import Triangles
from robodyn.support.floats import Floats

LARGEST_OF_SHELL = 0.1
"""Share of a shell that may be missing: a box without one of its 12 triangles is filled, without a side it is not."""
LARGEST_OF_ALL = 0.01
"""Share of the whole surface that what is missing from shells may have together, however open they are."""
_BODY = 0.3
"""Share of an open shell that may be missing for it to be a body with a hole, rather than a patch of one."""
_BULGE = 0.2
"""Volume, over the area of a hole to the power 3/2, that may lie between its cap and the surface that was there: twice
what lies between the cap of a round or a square hole and where the winding number is 1/3 or 2/3."""
_SEAM = 1e-6
"""Area over squared perimeter below which a gap is a seam: a T-junction, or an edge drawn twice."""


@dataclass(frozen=True)
class Filling:
    """Shells with holes, and seams of no area, filled by so many triangles.

    doubt: volume by which what was missing may differ from these; left: gaps too large to be filled; missing: their
    share of the surface of these shells with gaps filled; capped: the shells with `caps` faces as their last, which
    close the rest: across a hole of a body, and of patches a cone from one vertex over all their rims.
    """

    shells: Shells
    capped: Shells
    caps: int
    holes: int
    seams: int
    triangles: int
    doubt: float
    left: int
    missing: float


def filled(shells: Shells) -> Filling:
    """Fill the boundary loops of open shells with triangles, without new corners, unless they are large."""
    mesh = shells.mesh
    face_areas = areas(mesh.corners)
    gaps = _gaps(shells, face_areas)
    loose = [gap for gap in gaps if gap.share > LARGEST_OF_SHELL]
    if sum(gap.area for gap in loose) <= LARGEST_OF_ALL * float(face_areas.sum()):
        loose = []
    fill = [gap for gap in gaps if not loose or gap.share <= LARGEST_OF_SHELL]
    caps = [cap for gap in fill for cap in gap.caps]
    sizes = [size for gap in fill for size in gap.sizes]
    around = [
        float(np.linalg.norm(mesh.vertices[loop] - mesh.vertices[np.roll(loop, -1)], axis=1).sum())
        for gap in fill
        for loop in gap.loops
    ]
    seams = sum(size <= _SEAM * length**2 for size, length in zip(sizes, around, strict=True))
    after = _with(shells, fill, [gap.caps for gap in fill], fill)
    apex = next((gap.loops[0][0] for gap in loose if gap.patch), -1)
    rest = [gap.cone(apex) if gap.patch else gap.caps for gap in loose]
    missing, present = sum(gap.area for gap in loose), sum(gap.own for gap in loose)
    return Filling(
        shells=after,
        capped=_with(after, loose, rest, [gap for gap in loose if not gap.patch]),
        caps=sum(len(cap) for caps in rest for cap in caps),
        holes=len(caps) - seams,
        seams=seams,
        triangles=sum(map(len, caps)),
        doubt=_BULGE * sum(size**1.5 for size in sizes),
        left=sum(len(gap.caps) for gap in loose),
        missing=missing / (missing + present) if missing else 0.0,
    )


@dataclass(frozen=True, eq=False)
class _Gap:
    """What is missing of an open shell: loops around it, their caps, the areas of these and of the shell."""

    shell: int
    loops: list[list[int]]
    caps: list[Numbers]
    sizes: list[float]
    own: float

    @property
    def area(self) -> float:
        return sum(self.sizes)

    @property
    def share(self) -> float:
        return self.area / ((self.area + self.own) or 1.0)

    @property
    def patch(self) -> bool:
        """Whether the shell is a patch of a body, rather than a body with a hole."""
        return self.share > _BODY

    def cone(self, apex: int) -> list[Numbers]:
        """Return triangles (n, 3) from each loop to a vertex."""
        sides = [zip([loop[-1], *loop[:-1]], loop, strict=True) for loop in self.loops]
        faces = [[(a, b, apex) for a, b in side if apex not in (a, b)] for side in sides]
        return [np.array(each, np.int64).reshape(-1, 3) for each in faces]


def _gaps(shells: Shells, face_areas: Floats) -> list[_Gap]:
    mesh = shells.mesh
    own = np.bincount(shells.label, face_areas, shells.count).tolist()
    shell_of, starts, stops = shells.rim.T
    loops = {}
    for shell in np.flatnonzero(~shells.closed).tolist():
        first, last = np.searchsorted(shell_of, [shell, shell + 1])
        loops[shell] = followed(starts[first:last].tolist(), stops[first:last].tolist())
    caps = {shell: [cap_of(mesh.vertices, loop) for loop in around] for shell, around in loops.items()}
    every = [cap for each in caps.values() for cap in each]
    whole = areas(mesh.vertices[np.concatenate([np.zeros((0, 3), np.int64), *every])])
    ends = np.cumsum([len(cap) for cap in every])
    sizes = iter([float(part.sum()) for part in np.split(whole, ends[:-1])])
    return [_Gap(k, loops[k], caps[k], [next(sizes) for _ in caps[k]], own[k]) for k in loops]


def _with(shells: Shells, gaps: list[_Gap], caps: list[list[Numbers]], closed: list[_Gap]) -> Shells:
    """Return the shells with the caps of each gap as their last faces, and those of some of the gaps closed."""
    done = shells.closed.copy()
    done[[gap.shell for gap in closed]] = True
    mesh = replace(shells.mesh, faces=np.concatenate([shells.mesh.faces, *(cap for each in caps for cap in each)]))
    labels = [np.full(sum(map(len, each)), gap.shell, np.int64) for gap, each in zip(gaps, caps, strict=True)]
    rim = shells.rim[~done[shells.rim[:, 0]]]
    return replace(shells, mesh=mesh, label=np.concatenate([shells.label, *labels]), closed=done, rim=rim)


def followed(starts: list[int], stops: list[int]) -> list[list[int]]:
    """Return directed edges as loops that pass no vertex twice."""
    onward: dict[int, list[int]] = {}
    for start, stop in zip(starts, stops, strict=True):
        onward.setdefault(start, []).append(stop)
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
    points = dict(zip(loop, vertices[loop].tolist(), strict=True))
    before = dict(zip(loop, [loop[-1], *loop[:-1]], strict=True))
    after = {vertex: follower for follower, vertex in before.items()}

    def ear(vertex: int) -> tuple[float, int, int, int]:
        a, c = before[vertex], after[vertex]
        (x, y, z), (u, v, w) = points[a], points[c]
        x, y, z = u - x, v - y, w - z
        return sqrt(x * x + y * y + z * z), vertex, a, c

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


class Gaps(NamedTuple):
    """Gaps that repair fills, those left as too large and the share of open parts that they are, one-sided faces."""

    mended: int = 0
    left: int = 0
    missing: float = 0.0
    one_sided: int = 0


def gaps(triangles: Triangles) -> Gaps:
    """Return the gaps of a surface without its superfluous faces."""
    mesh, _ = without_duplicates(without_degenerate(merged(triangles.array())))
    if not len(mesh.faces):
        return Gaps()
    shells, _ = wound(mesh)
    twisted = one_sided(shells)
    if twisted:
        return Gaps(one_sided=twisted)
    filling = filled(shells)
    return Gaps(filling.holes + filling.seams, filling.left, filling.missing)


def one_sided(shells: Shells) -> int:
    """Return how many faces are in surfaces that cannot be wound, whose inside and outside are not told apart. Open
    ones with rims put together where they nearly meet: caps on those of a Klein bottle would give it two sides."""
    if not shells.closed.all():
        whole = welded(shells.mesh, shells.lone)
        shells = shells if whole is shells.mesh else wound(whole)[0]
    return shells.twisted
