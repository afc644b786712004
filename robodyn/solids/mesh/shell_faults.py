"""Shells of a closed surface that are wound the wrong way or reach into each other, told by a few points of each."""

from __future__ import annotations

from functools import cache

import numpy as np

from robodyn.solids.mesh.indexed import Mask, components, in_parts, merged, triple
from robodyn.solids.mesh.inside import Interior
from robodyn.solids.mesh.triangles import Triangles
from robodyn.support.floats import Floats

_PAIRS = 16
"""Pairs of shells that are tried for what they share."""
_BODIES = 16
"""Bodies in which an inward shell may be a cavity; where more are around it, it is not judged."""
_POINTS = 16
"""Points of a shell that are tried."""
_FLAT = 1e-9
"""Volume over that of the box below which a shell has no inside."""
_DEEP = 1e-4
"""How far into another shell's box a point must lie, over its size, to be tried."""


def shell_faults(triangles: Triangles) -> tuple[int, bool]:
    """Return how many shells are wound inwards without being cavities, and whether two wound outwards share volume.

    Shells are the components of triangles that share corners. One that is wound inwards is a cavity if it reaches into
    one wound outwards; two wound outwards of which one has points within the other, outside all cavities, count what
    they share twice. Of many shells only the pairs that share most of their boxes are tried: what is found is there,
    but shells that hardly meet may be missed.

    Args:
        triangles: a closed surface.
    """
    mesh = merged(triangles.array())
    a, b, c = mesh.faces.T
    label = components(len(mesh.vertices), np.concatenate([a, a]), np.concatenate([b, c]))[a]
    parts, lo, hi = in_parts(mesh.corners, label)
    volumes = np.array([float(triple(part - part[0, 0]).sum()) / 6 for part in parts])
    sizes = np.prod(hi - lo, axis=1)
    solid = np.abs(volumes) > _FLAT * sizes
    bodies, inward = solid & (volumes > 0), np.flatnonzero(solid & (volumes < 0)).tolist()
    interior = cache(lambda shell: Interior(parts[shell]))

    def has(shell: int, point: Floats) -> bool:
        return bool(((lo[shell] < point) & (point < hi[shell])).all() and interior(shell).has(point))

    def points_in(shell: int, body: int) -> list[Floats]:
        return [point for point in _points(parts[shell], lo[body], hi[body]) if has(body, point)]

    def may_be_cavity(shell: int) -> bool:
        around = np.flatnonzero(_shared(lo, hi, shell, bodies)).tolist()
        return len(around) > _BODIES or any(points_in(shell, body) for body in around)

    pairs = []
    for body in np.flatnonzero(bodies).tolist():
        shared = _shared(lo, hi, body, bodies)
        pairs += [(-shared[one] / sizes[one], one, body) for one in np.flatnonzero(shared).tolist()]
    overlapping = any(
        not any(has(cavity, point) for cavity in inward)
        for _, one, body in sorted(pairs)[:_PAIRS]
        for point in points_in(one, body)
    )
    return sum(not may_be_cavity(shell) for shell in inward), overlapping


def _shared(lo: Floats, hi: Floats, shell: int, others: Mask) -> Floats:
    """(k,) volume that the boxes of other shells share with that of a shell."""
    common = np.minimum(hi, hi[shell]) - np.maximum(lo, lo[shell])
    volume: Floats = np.where((common > 0).all(axis=1) & others, np.prod(common, axis=1), 0.0)
    volume[shell] = 0.0
    return volume


def _points(shell: Floats, lo: Floats, hi: Floats) -> Floats:
    """Corners and centres of triangles and of their sides, well within a box, those of the largest triangles."""
    a, b, c = shell.transpose(1, 0, 2)
    margin = _DEEP * (hi - lo)
    points = np.concatenate([(a + b + c) / 3, (a + b) / 2, (b + c) / 2, (c + a) / 2, a, b, c])
    near = np.flatnonzero(((points > lo + margin) & (points < hi - margin)).all(axis=1))
    if len(near) > _POINTS:
        rows = near % len(shell)
        area = (np.cross(b[rows] - a[rows], c[rows] - a[rows]) ** 2).sum(axis=1)
        near = near[np.lexsort((-area, near // len(shell)))[:_POINTS]]
    chosen: Floats = points[near]
    return chosen
