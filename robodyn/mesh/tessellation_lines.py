"""The volume between facets and the smooth surface they stand for, as masses along edges."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

import numpy as np

from robodyn.mesh.indexed import Mask
from robodyn.mesh.tessellation_edges import BENT, SHARPEST, BentEdges, Floats, bent_edges
from robodyn.spatial import Array

FINE = radians(40)
"""Facets that meet at a larger angle are too coarse to say how symmetric a body may be that they stand for."""

_TIMES_MEDIAN = 3
_SIMILAR = 1 / 3
_INNER = 1.4
_BESIDE = 0.02
_UNLIKE = 3
_SHARE = 0.25
_ALONE = 0.75
_SHARP = 1.2
_ENDING = 2.0
_SAME = 0.1
_STEEP = 0.35
_CLEARLY = 0.05


@dataclass(frozen=True, eq=False)
class LineMasses:
    """What lies between facets and surface, spread evenly along each edge.

    Attributes:
        start, end: (3, k) of edges.
        missing: (k,) volume, negative where facets take in too much.
        doubt: (k,) how far it may be from that.
        fine: (k,) whether the angle is below 40 degrees, and below three times the median one.
    """

    start: Floats
    end: Floats
    missing: Floats
    doubt: Floats
    fine: Mask

    @property
    def size(self) -> float:
        """The volume between fine facets and the surface, whatever its sign."""
        return float(np.abs(self.missing[self.fine]).sum())


def line_masses(corners: Array) -> LineMasses:
    """The volume that facets leave out, as far as angles and heights tell, where corners are on the smooth surface.

    An edge of length l between triangles of heights h1, h2 that meet at an angle th lacks l h_i^2 t_i / 24 on either
    side, t_i = 2 th h_i / (h1 + h2): that is the volume between a cylinder, or any surface of the second order, and a
    regular grid of facets, but for higher orders of th. A facet is all triangles in one plane. Exceptions are these.

    - Where the facet on one side is more than three times the other, it lies in a plane that touches a fillet, unless
      it is a triangle whose edges are all bent and one has facets more alike: t = 0 on its side, 2 th on the other.
    - A triangle with two bent edges, bent by more than 0.35 of the angle between them, and a sharp one is at the apex
      of a cone: that lacks a third. Between equal trapezoids of widths w1, w2 an edge lacks
      l th (w1^2 + w1 w2 + w2^2) / 36.
    - A facet that has no other edge which is bent the same way by a third of this one at least, or at a plane by 1.4
      times, may be curved or not: half of what would be missing is, and three quarters are doubt.
    - Where neither facet is bent anywhere else, as at the ridge of a roof, nothing is missing.
    - Edges of 65 to 120 degrees are meant as they are; where both facets have others below 65 that is in doubt.

    The doubt is a quarter of what is missing, and l th (h1 - h2)^2 / 9 where triangles are uneven; and twice all of it
    where a smooth surface ends at a sharp edge, behind which nothing tells how it goes on.

    Args:
        corners: (m, 3, 3), wound outwards; an edge has the same bits in both its triangles.
    """
    edges = _smooth(bent_edges(corners))
    size = np.abs(edges.angle)
    counted = size[size > BENT] if (size > BENT).any() else size
    median = _median(counted) if len(size) else 0.0
    missing, doubt = _of_smooth(edges, _CLEARLY * median)
    fine = size < min(FINE, _TIMES_MEDIAN * median)
    return LineMasses(edges.start, edges.end, missing, doubt, fine)


def _smooth(edges: BentEdges) -> BentEdges:
    """Without those that are meant as they are."""
    angle = np.abs(edges.angle)
    sharp = angle > SHARPEST
    if sharp.any():
        sharp &= (_companions(edges, ~sharp) <= BENT).any(axis=0)
    ratio = _companions(edges, angle <= SHARPEST) / angle
    meant = sharp | ((ratio <= _BESIDE).all(axis=0) & (angle <= SHARPEST))
    return edges.among(~meant)


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
    count = np.bincount(edges.triangles[:, clear].ravel(), minlength=len(edges.flat))
    curved = np.zeros_like(edges.flat)
    curved[edges.triangles[:, _like(edges) & clear]] = True
    plane = _planes(edges, curved & (count == 3))
    sides = _sides(edges, plane)
    size, angle = np.abs(sides), np.abs(edges.angle)
    sharp = angle > SHARPEST
    alone = _companions(edges, ~sharp) / angle < np.where(plane[::-1], _INNER, _SIMILAR)
    ending = ((count == 2) & ~edges.flat)[edges.triangles]
    steep = ending & (angle * edges.length > _STEEP * edges.heights)
    taper, uneven = _taper(edges)
    missing = np.where(alone, sides / 2, np.where(steep, sides / 3, sides)).sum(axis=0) - taper
    share = np.where(sharp, _SHARP, np.where(alone, _ALONE, _SHARE)) + np.where(ending, _ENDING, 0.0)
    return np.where(sharp, 0.0, missing), (share * size).sum(axis=0) + uneven


def _companions(edges: BentEdges, among: Mask) -> Floats:
    """(2, k) the largest angle at other edges of the facet on each side that bend the same way, 0 if there are none.

    Args:
        among: (k,) which edges these may be.
    """
    size = np.tile(np.where(among, np.abs(edges.angle), 0.0), 2)
    if not len(size):
        return np.zeros((2, 0))
    facet = 2 * edges.facet[edges.triangles].ravel() + (np.tile(edges.angle, 2) < 0)
    order = np.lexsort((size, facet))
    facet, size = facet[order], size[order]
    last = np.append(facet[1:] != facet[:-1], True)
    largest = size[np.flatnonzero(last)[np.cumsum(last) - last]]
    first = np.append(True, last[:-1])
    second = np.where(first, 0.0, np.append(0.0, size[:-1]))
    found = np.empty_like(size)
    found[order] = np.where(last, second, largest)
    return found.reshape(2, -1)


def _like(edges: BentEdges) -> Mask:
    """(k,) whether the facets on both sides are of the same kind, and not the plane that a fillet touches."""
    areas = edges.areas[edges.triangles]
    like: Mask = areas.max(axis=0) <= _UNLIKE * areas.min(axis=0)
    return like


def _taper(edges: BentEdges) -> tuple[Floats, Floats]:
    """(k,) what is missing less where facets taper, and the doubt where heights differ.

    Between equal trapezoids of widths w1, w2 lacks l th (w1^2 + w1 w2 + w2^2) / 36, but the rule for heights says
    l th (w1^2 - w1 w2 + w2^2) / 12.
    """
    one, other = edges.areas[edges.triangles]
    differ = edges.length * edges.angle * (edges.heights[0] - edges.heights[1]) ** 2
    tapers = edges.flat[edges.triangles].all(axis=0) & (np.abs(one - other) <= _SAME * (one + other))
    uneven = np.where(_like(edges), np.abs(differ) / 9, 0.0)
    return np.where(tapers, differ / 18, 0.0), np.where(tapers, uneven / 4, uneven)


def _planes(edges: BentEdges, curved: Mask) -> Mask:
    """(2, k) which sides are planes that touch a fillet."""
    areas = edges.areas[edges.triangles]
    planes: Mask = (areas > _UNLIKE * areas[::-1]) & ~curved[edges.triangles]
    return planes


def _sides(edges: BentEdges, plane: Mask) -> Floats:
    """(2, k) missing on either side."""
    heights = edges.heights
    volume = edges.length * edges.angle / 12
    even = volume * heights**3 / heights.sum(axis=0)
    return np.where(plane, 0.0, np.where(plane[::-1], volume * heights**2, even))
