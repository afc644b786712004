"""Convex polyhedra of fixed-point coordinates, and what two of them have in common, in exact arithmetic."""

from __future__ import annotations

import itertools
from fractions import Fraction
from math import gcd

import numpy as np
from scipy.spatial import ConvexHull

from helpers.mesh_oracle import rational_moments

UNIT = 2.0**-20
"""All coordinates are multiples of this."""


def hull(points):
    """The triangles (m, 3, 3) of the convex hull, wound outwards."""
    points = np.round(np.asarray(points) / UNIT) * UNIT
    found = ConvexHull(points)
    triangles = points[found.simplices]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    inwards = (normals * found.equations[:, :3]).sum(axis=1) < 0
    triangles[inwards] = triangles[inwards, ::-1]
    return triangles


def ball(count, radius, centre=(0.0, 0.0, 0.0)):
    """Points spread evenly over a sphere by the golden angle."""
    k = np.arange(count) + 0.5
    z, turn = 1 - 2 * k / count, np.pi * (1 + 5**0.5) * k
    across = np.sqrt(1 - z * z)
    return hull(np.asarray(centre) + radius * np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1))


def rod(sectors, low, high, length, axis=2, phase=0.1):
    """A frustum of a cone, or a cylinder where both radii are the same, along an axis."""
    turn = 2 * np.pi * np.arange(sectors) / sectors + phase
    rings = [
        np.stack([radius * np.cos(turn), radius * np.sin(turn), np.full(sectors, z)], axis=1)
        for radius, z in ((low, -length / 2), (high, length / 2))
    ]
    return hull(np.roll(np.concatenate(rings), axis + 1, axis=1))


def common_moments(one, other):
    """Volume, first and second moments about the origin of the intersection, as fractions.

    Its boundary is what of either surface lies in the other body; what lies in both surfaces counts once.
    """
    one, other = _numbers(one), _numbers(other)
    polygons = [*_within(one, other, False), *_within(other, one, True)]
    fans = [(p, q, r) for p, *others in polygons for q, r in itertools.pairwise(others)]
    volume, first, second = rational_moments([x for fan in fans for corner in fan for x in corner], (0, 0, 0))
    unit = Fraction(UNIT)
    return volume * unit**3, first * unit**4, second * unit**5


def _numbers(triangles):
    """Corners in whole units."""
    return [[tuple(map(int, corner)) for corner in triangle] for triangle in (np.asarray(triangles) / UNIT).tolist()]


def _planes(triangles):
    """(normal, offset) of each, normal . x <= offset inside; no plane twice. The body must be convex."""
    found = {(normal, _dot(normal, triangle[0])) for triangle in triangles for normal in [_normal(triangle)]}
    corners = {corner for triangle in triangles for corner in triangle}
    assert all(_dot(normal, corner) <= offset for normal, offset in found for corner in corners)
    return found


def _normal(triangle):
    a, b, c = triangle
    e, f = ([y - x for x, y in zip(a, p, strict=True)] for p in (b, c))
    normal = [e[i - 2] * f[i - 1] - e[i - 1] * f[i - 2] for i in range(3)]
    size = gcd(*normal)
    return tuple(x // size for x in normal)


def _dot(normal, corner):
    return normal[0] * corner[0] + normal[1] * corner[1] + normal[2] * corner[2]


def _within(polygons, triangles, strictly):
    """The parts of triangles in a convex body; those in one of its faces, wound alike, only if not strictly."""
    planes = _planes(triangles)
    for polygon in polygons:
        left, own = polygon, _normal(polygon)
        place = _dot(own, polygon[0])
        for normal, offset in planes:
            left = _cut(left, normal, offset)
            if not left or (strictly and (normal, offset) == (own, place)):
                break
        else:
            yield left


def _cut(polygon, normal, offset):
    heights = [_dot(normal, corner) - offset for corner in polygon]
    if max(heights) <= 0:
        return polygon
    kept = []
    for p, h, q, k in zip(polygon, heights, polygon[1:] + polygon[:1], heights[1:] + heights[:1], strict=True):
        if h <= 0:
            kept.append(p)
        if h * k < 0:
            part = Fraction(h, 1) / (h - k)
            kept.append(tuple(x + (y - x) * part for x, y in zip(p, q, strict=True)))
    return kept if len(kept) > 2 else []
