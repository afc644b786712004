"""The volume between facets and the smooth surface they stand for, as masses along edges."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

import numpy as np

from robodyn.programs.vectors import Array
from robodyn.solids.mesh.indexed import Mask
from robodyn.solids.mesh.tessellation.edges import BENT, SHARPEST, BentEdges, Integers, bent_edges
from robodyn.solids.mesh.tessellation.facets import companions, endings, like, opposed, planes, sides, taper
from robodyn.support.floats import Floats

FINE = radians(40)
"""Facets that meet at a larger angle are too coarse to say how symmetric a body may be that they stand for."""

_TIMES_MEDIAN = 3
_SQUARE = radians(88)
_SIMILAR = 1 / 3
_INNER = 1.4
_BESIDE = 0.02
_SHARE = 0.25
_ALONE = 0.6
_SHARP = 0.9
_ENDING = 1.5
_FAR = 0.75
_STEEP = 0.35
_WIDE = 0.35
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
      times, may be curved or not: half of what would be missing is, and 0.6 of it is doubt.
    - Where neither facet is bent anywhere else, as at the ridge of a roof, nothing is missing.
    - Edges of 65 to 120 degrees are meant as they are, unless the facets are of a kind and both have other bent edges
      below 65, and above 88 degrees these opposite to them: then that is in doubt.
    - Where a curved facet ends at a sharp edge opposite to this one, there is no edge to stand for the far half of it:
      that lacks as much again, at three quarters of the way across.

    The doubt is a quarter of what is missing, and l th (h1 - h2)^2 / 9 where triangles are uneven; and one and a half
    times all of it at such an end, and at the apex of a coarse cone.

    Args:
        corners: (m, 3, 3), wound outwards; an edge has the same bits in both its triangles.
    """
    edges = _smooth(bent_edges(corners))
    size = np.abs(edges.angle)
    counted = size[size > BENT] if (size > BENT).any() else size
    median = _median(counted) if len(size) else 0.0
    fine = size < min(FINE, _TIMES_MEDIAN * median)
    parts = _of_smooth(edges, _CLEARLY * median)
    start, end, missing, doubt, edge = (np.concatenate(column, axis=-1) for column in zip(*parts, strict=True))
    return LineMasses(start, end, missing, doubt, fine[edge])


def _smooth(edges: BentEdges) -> BentEdges:
    """Without those that are meant as they are."""
    angle = np.abs(edges.angle)
    sharp = angle > SHARPEST
    if sharp.any():
        bent = (companions(edges, ~sharp) > BENT).all(axis=0) & (angle < _SQUARE)
        sharp &= ~(like(edges) & (bent | opposed(edges, ~sharp & (angle > BENT))))
    ratio = companions(edges, angle <= SHARPEST) / angle
    meant = sharp | ((ratio <= _BESIDE).all(axis=0) & (angle <= SHARPEST))
    return edges.among(~meant)


def _median(values: Floats) -> float:
    """As `np.median`, which would import `numpy.ma`."""
    half = len(values) // 2
    low, high = (half - 1, half) if len(values) % 2 == 0 else (half, half)
    found = np.partition(values, (low, high))
    return float((found[low] + found[high]) / 2)


def _spread(edges: BentEdges, steep: Mask) -> tuple[Floats, Floats]:
    """Starts and ends (3, k) of where volume is missing: at the apex of a cone the half away from it.

    There it is missing as the square of the distance s from the apex: at 3/4 of the length on the average, as in that
    half; the mean of s^2 is 0.6, and 0.583 there.
    """
    middle = (edges.start + edges.end) / 2
    at_start = edges.feet.mean(axis=0) > 0.5
    return np.where(steep & at_start, middle, edges.start), np.where(steep & ~at_start, middle, edges.end)


def _of_smooth(edges: BentEdges, least: float) -> list[tuple[Floats, Floats, Floats, Floats, Integers]]:
    """Starts, ends, missing volumes, doubts and numbers of edges: at these, and at the far ends of facets on each side.

    Args:
        least: angle below which an edge may be one of a plane, and says nothing about its triangles.
    """
    clear = np.abs(edges.angle) > least
    count = np.bincount(edges.triangles[:, clear].ravel(), minlength=len(edges.flat))
    alike = np.zeros_like(edges.flat)
    alike[edges.triangles[:, like(edges) & clear]] = True
    plane = planes(edges, alike & (count == 3))
    lacking = sides(edges, plane)
    size, angle = np.abs(lacking), np.abs(edges.angle)
    sharp = angle > SHARPEST
    alone = companions(edges, ~sharp) / angle < np.where(plane[::-1], _INNER, _SIMILAR)
    curved = companions(edges, ~sharp, either=True) > _BESIDE * angle
    apex = ((count == 2) & ~edges.flat)[edges.triangles]
    steep = apex & (angle * edges.length > _STEEP * edges.heights)
    wide = steep & (edges.heights > _WIDE * edges.length)
    less, uneven = taper(edges)
    missing = np.where(steep, lacking / 3, np.where(alone, lacking / 2, lacking))
    share = np.where(sharp, _SHARP, np.where(alone, _ALONE, _SHARE)) + np.where(wide, _ENDING, 0.0)
    here = np.where(sharp, 0.0, missing.sum(axis=0) - less), (share * size).sum(axis=0) + uneven
    found = [(*_spread(edges, steep.all(axis=0)), *here, np.arange(len(angle)))]
    ending = endings(edges) & ~steep & curved
    for side in (0, 1):
        (chosen,) = np.nonzero(ending[side])
        across = edges.outward[side][:, chosen] * (_FAR * edges.heights[side][chosen])
        there = np.where(sharp, 0.0, missing[side])[chosen], _ENDING * size[side][chosen]
        found.append((edges.start[:, chosen] - across, edges.end[:, chosen] - across, *there, chosen))
    return found
