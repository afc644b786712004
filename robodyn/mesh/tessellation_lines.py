"""The volume between facets and the smooth surface they stand for, as masses along edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robodyn.mesh.tessellation_edges import BENT, BentEdges, Floats, bent_edges
from robodyn.spatial import Array

_TIMES_MEDIAN = 3
_UNLIKE = 3
_SHARE = 0.2
_STEEP = 0.35
_CLEARLY = 0.05


@dataclass(frozen=True, eq=False)
class LineMasses:
    """What lies between facets and surface, spread evenly along each edge.

    Attributes:
        start, end: (3, k) of edges.
        missing: (k,) volume, negative where facets take in too much.
        doubt: (k,) how far it may be from that.
    """

    start: Floats
    end: Floats
    missing: Floats
    doubt: Floats

    @property
    def size(self) -> float:
        """The volume between facets and surface, whatever its sign."""
        return float(np.abs(self.missing).sum())


def line_masses(corners: Array) -> LineMasses:
    """The volume that facets leave out, as far as angles and heights tell.

    An edge of length l between triangles of heights h1, h2 that meet at an angle th, below 40 degrees and three times
    the median one, lacks l h_i^2 t_i / 24 on either side, t_i = 2 th h_i / (h1 + h2): that is the volume between a
    cylinder, or any surface of the second order, and a regular grid of facets, but for higher orders of th. There are
    three exceptions.

    - Where one height is more than three times the other, its triangle lies in a plane that touches a fillet, unless
      all its edges are smooth and one has heights more alike: t = 0 on its side, and 2 th on the other.
    - A triangle with two smooth edges, bent by more than 0.35 of the angle between them, and a sharp one is at the apex
      of a cone: that lacks a third.
    - Edges between three times the median angle and 40 degrees may be smooth or meant so: they are all doubt.

    The doubt is a fifth of what is missing, and l th (h1 - h2)^2 / 9, since cones and uneven triangles lack less or
    more; and twice all of it where a smooth surface ends at a sharp edge, behind which nothing tells how it goes on.

    Args:
        corners: (m, 3, 3), wound outwards; an edge has the same bits in both its triangles.
    """
    edges = bent_edges(corners)
    size = np.abs(edges.angle)
    counted = size[size > BENT] if (size > BENT).any() else size
    median = _median(counted) if len(size) else 0.0
    smooth = size < _TIMES_MEDIAN * median
    missing, doubt = np.zeros((2, len(size)))
    missing[smooth], doubt[smooth] = _of_smooth(edges.among(smooth), _CLEARLY * median)
    rest = ~smooth
    doubt[rest] = np.abs(_sides(edges.among(rest), np.zeros_like(edges.flat)).sum(axis=0))
    return LineMasses(edges.start, edges.end, missing, doubt)


def _median(values: Floats) -> float:
    """As `np.median`, which would import `numpy.ma`."""
    half = len(values) // 2
    low, high = (half - 1, half) if len(values) % 2 == 0 else (half, half)
    found = np.partition(values, (low, high))
    return float((found[low] + found[high]) / 2)


def _of_smooth(edges: BentEdges, least: float) -> tuple[Floats, Floats]:
    """Missing volumes and doubts.

    Args:
        least: angle below which an edge may be one of a plane, and says nothing about its triangles.
    """
    clear = np.abs(edges.angle) > least
    low, high = edges.heights.min(axis=0), edges.heights.max(axis=0)
    like = high <= _UNLIKE * low
    count = np.bincount(edges.triangles[:, clear].ravel(), minlength=len(edges.flat))
    curved = np.zeros_like(edges.flat)
    curved[edges.triangles[:, like & clear]] = True
    sides = _sides(edges, curved & (count == 3))
    size = np.abs(sides)
    ending = ((count == 2) & ~edges.flat)[edges.triangles]
    uneven = edges.length * np.abs(edges.angle) * np.where(like, high - low, 0) ** 2 / 9
    steep = ending & (np.abs(edges.angle) * edges.length > _STEEP * edges.heights)
    missing = np.where(steep, sides / 3, sides).sum(axis=0)
    return missing, _SHARE * size.sum(axis=0) + uneven + 2 * np.where(ending, size, 0).sum(axis=0)


def _sides(edges: BentEdges, curved: NDArray[np.bool_]) -> Floats:
    """(2, k) missing on either side."""
    heights, others = edges.heights, edges.heights[::-1]
    volume = edges.length * edges.angle / 12
    even = volume * heights**3 / heights.sum(axis=0)
    plane = (heights > _UNLIKE * others) & ~curved[edges.triangles]
    return np.where(plane, 0.0, np.where(plane[::-1], volume * heights**2, even))
