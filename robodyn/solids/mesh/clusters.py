"""Points in groups of neighbours."""

from __future__ import annotations

import numpy as np

from robodyn.programs.vectors import product
from robodyn.solids.mesh.columns import frame_along
from robodyn.solids.mesh.indexed import Numbers
from robodyn.solids.mesh.triangles import Floats

_FRAME = frame_along(np.array((0.36, 0.48, 0.8)))
"""Along nothing that a part has, so that its points do not lie side by side."""


def clusters(points: Floats, most: int) -> list[Numbers]:
    """The numbers of points (n, 3) in groups of at most `most`.

    Groups are cut across their longest side until they are small, each at the widest gap in its middle third: points
    that nearly coincide stay together.
    """
    n = len(points)
    if not n:
        return []
    points = product(points, _FRAME.T)
    order, starts = np.arange(n), np.zeros(1, np.int64)
    while (sizes := np.diff(starts, append=n)).max() > most:
        P = points[order]
        extent = np.maximum.reduceat(P, starts) - np.minimum.reduceat(P, starts)
        group = np.repeat(np.arange(len(starts)), sizes)
        along = P[np.arange(n), np.argmax(extent, axis=1)[group]]
        sort = np.lexsort((along, group))
        order, along = order[sort], along[sort]
        starts = np.union1d(starts, _cuts(along, starts, sizes, group)[sizes > most])
    return np.split(order, starts[1:])


def _cuts(along: Floats, starts: Numbers, sizes: Numbers, group: Numbers) -> Numbers:
    """Of each group, the place of the point after its widest gap."""
    gap = np.diff(along, prepend=along[0])
    place = np.arange(len(along)) - starts[group]
    third = np.maximum(sizes // 3, 1)[group]
    gap[(place < third) | (place > sizes[group] - third)] = -1
    widest = np.flatnonzero(gap == np.maximum.reduceat(gap, starts)[group])
    _, first = np.unique(group[widest], return_index=True)
    cuts: Numbers = widest[first]
    return cuts
