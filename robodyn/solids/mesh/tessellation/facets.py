"""What facets on both sides of an edge say about the surface that they stand for."""

from __future__ import annotations

import numpy as np

from robodyn.solids.mesh.indexed import Mask
from robodyn.solids.mesh.tessellation.edges import BENT, BentEdges
from robodyn.support.floats import Floats

_UNLIKE = 3
_UNPAIRED = 0.6
_SAME = 0.1


def endings(edges: BentEdges) -> Mask:
    """(2, k) whether the facet on each side ends at a sharp edge opposite to this one."""
    return _unpaired(edges, np.abs(edges.angle) > BENT) > _UNPAIRED


def opposed(edges: BentEdges, among: Mask) -> Mask:
    """(k,) whether the facets on both sides end at some of these edges opposite to this one.

    Args:
        among: (k,) which edges these may be; not this one.
    """
    found: Mask = np.all(_unpaired(edges, among) < -_UNPAIRED, axis=0)
    return found


def _unpaired(edges: BentEdges, among: Mask) -> Floats:
    """(2, k) what some edges of the facet on each side leave unpaired across this one, over its length.

    Lengths times outward vectors add up to zero around a facet: what some edges leave is what the others have.
    """
    facet = edges.facet[edges.triangles].ravel()
    weights = (edges.outward * np.where(among, edges.length, 0.0)).transpose(1, 0, 2).reshape(3, -1)
    left = np.stack([np.bincount(facet, one, len(edges.areas)) for one in weights])[:, facet].reshape(3, 2, -1)
    found: Floats = (left * edges.outward.transpose(1, 0, 2)).sum(axis=0) / edges.length
    return found


def companions(edges: BentEdges, among: Mask, either: bool = False) -> Floats:
    """(2, k) the largest angle at other edges of the facet on each side that bend the same way, 0 if there are none.

    Args:
        among: (k,) which edges these may be. either: they may bend either way.
    """
    size = np.tile(np.where(among, np.abs(edges.angle), 0.0), 2)
    if not len(size):
        return np.zeros((2, 0))
    facet = 2 * edges.facet[edges.triangles].ravel() + (not either) * (np.tile(edges.angle, 2) < 0)
    largest, second = np.zeros((2, 2 * len(edges.areas)))
    np.maximum.at(largest, facet, size)
    top = size == largest[facet]
    np.maximum.at(second, facet, np.where(top, 0.0, size))
    only = top & (np.bincount(facet, top)[facet] == 1)
    found = np.where(only, second[facet], largest[facet])
    return found.reshape(2, -1)


def like(edges: BentEdges) -> Mask:
    """(k,) whether the facets on both sides are of the same kind, and not the plane that a fillet touches."""
    areas = edges.areas[edges.triangles]
    like: Mask = areas.max(axis=0) <= _UNLIKE * areas.min(axis=0)
    return like


def taper(edges: BentEdges) -> tuple[Floats, Floats]:
    """(k,) what is missing less where facets taper, and the doubt where heights differ.

    Between equal trapezoids of widths w1, w2 lacks l th (w1^2 + w1 w2 + w2^2) / 36, but the rule for heights says
    l th (w1^2 - w1 w2 + w2^2) / 12.
    """
    one, other = edges.areas[edges.triangles]
    differ = edges.length * edges.angle * (edges.heights[0] - edges.heights[1]) ** 2
    tapers = edges.flat[edges.triangles].all(axis=0) & (np.abs(one - other) <= _SAME * (one + other))
    uneven = np.where(like(edges), np.abs(differ) / 9, 0.0)
    return np.where(tapers, differ / 18, 0.0), np.where(tapers, uneven / 4, uneven)


def planes(edges: BentEdges, curved: Mask) -> Mask:
    """(2, k) which sides are planes that touch a fillet."""
    areas = edges.areas[edges.triangles]
    planes: Mask = (areas > _UNLIKE * areas[::-1]) & ~curved[edges.triangles]
    return planes


def sides(edges: BentEdges, plane: Mask) -> Floats:
    """(2, k) missing on either side."""
    heights = edges.heights
    volume = edges.length * edges.angle / 12
    even = volume * heights**3 / heights.sum(axis=0)
    return np.where(plane, 0.0, np.where(plane[::-1], volume * heights**2, even))
