"""Winding numbers of open surfaces at many points: near triangles one by one, those far away as dipoles."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from robodyn.programs.vectors import product
from robodyn.solids.mesh.distinct import Numbers
from robodyn.solids.mesh.indexed import Indexed
from robodyn.solids.mesh.region.columns import frame_along
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

_FRAME = frame_along(np.array((0.36, 0.48, 0.8)))
"""Along nothing that a part has, so that its points do not lie side by side."""


def clusters(points: Floats, most: int) -> list[Numbers]:
    """Return the numbers of points (n, 3) in groups of at most `most`.

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


_LEAF = 16
"""Triangles of a cluster, at most."""

_BLOCK = 64
"""Points that have the same clusters far away, at most."""

_CHUNK = 512
"""Triangles at a time: intermediate results of a block of points stay in the cache."""

_FAR = 1.5
"""Distance, in radii of a cluster, from which on its triangles are dipoles."""


@dataclass(frozen=True, eq=False)
class WindingTree:
    """A surface in clusters of triangles.

    The solid angle of a cluster far away is the integral of n . r / r^3 to first order in the place of the triangles
    about the centre of the cluster (Barill, Dickson, Schmidt, Levin, Jacobson 2018); of near triangles it is that of
    `winding_numbers`. What is needed of a triangle, or a cluster, is a polynomial in the coordinates of the point: its
    values are a matrix product.

    Attributes:
        origin: (3,) of the coordinates in which the polynomials are.
        near: (clusters, leaf, 7, 5) coefficients of 1, x, y, z, x^2 + y^2 + z^2 of the squares of the distances a, b, c
            of the corners, of a.b, b.c, c.a and of det(a, b, c); zero where a cluster has fewer triangles.
        far: (3, clusters, 10) coefficients of 1, x, y, z and their products: of r^2 and of what is over r^3 and r^5.
        centre, radius: (clusters, 3), (clusters,).
    """

    origin: Floats
    near: Floats
    far: Floats
    centre: Floats
    radius: Floats

    @classmethod
    def of(cls, mesh: Indexed) -> WindingTree:
        corners = mesh.corners
        origin = corners.mean(axis=(0, 1)) if len(corners) else np.zeros(3)
        corners = corners - origin
        groups = clusters(corners.mean(axis=1), _LEAF)
        place = np.concatenate([np.arange(len(group)) for group in groups] or [np.empty(0, np.int64)])
        which = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
        leaves = np.zeros((len(groups), _LEAF, 3, 3))
        leaves[which, place] = corners[np.concatenate(groups)] if groups else corners
        area = np.cross(leaves[:, :, 1] - leaves[:, :, 0], leaves[:, :, 2] - leaves[:, :, 0]) / 2
        size = np.linalg.norm(area, axis=2)[..., None] + np.finfo(float).tiny
        used = (np.arange(_LEAF) < np.bincount(which, minlength=len(groups))[:, None])[..., None]
        middle = leaves.mean(axis=2)
        centre = (size * used * middle).sum(axis=1) / (size * used).sum(axis=1)
        apart = np.linalg.norm(leaves - centre[:, None, None], axis=3) * used
        return cls(origin, _near(leaves), _far(centre, area, middle), centre, apart.max(axis=(1, 2), initial=0))

    def numbers(self, points: Floats) -> Floats:
        """(n,) solid angle as seen from points (n, 3), over 4 pi.

        Accuracy: 5e-3 of surfaces that nowhere lie in more than a few layers.
        """
        found = np.zeros(len(points))
        for block in clusters(points, _BLOCK):
            found[block] = self._of(points[block] - self.origin)
        return found / (4 * pi)

    def _of(self, x: Floats) -> Floats:
        """Solid angles from points that lie together."""
        middle = (x.min(axis=0) + x.max(axis=0)) / 2
        reach = np.sqrt(((x - middle) ** 2).sum(axis=1).max())
        far = np.linalg.norm(self.centre - middle, axis=1) > _FAR * self.radius + reach
        u, v, w = x.T
        powers = np.stack([np.ones(len(x)), u, v, w, u * u, v * v, w * w, u * v, v * w, w * u])
        angles = _dipoles(powers, self.far[:, far])
        powers = np.stack([*powers[:4], (x * x).sum(axis=1)])
        triangles = self.near[~far].reshape(-1, 7, 5)
        for start in range(0, len(triangles), _CHUNK):
            angles += _triangles(powers, triangles[start : start + _CHUNK])
        return angles


def _near(leaves: Floats) -> Floats:
    A, B, C = np.moveaxis(leaves, 2, 0)
    found = np.zeros((*leaves.shape[:2], 7, 5))
    for k, (p, q) in enumerate(((A, A), (B, B), (C, C), (A, B), (B, C), (C, A))):
        found[:, :, k, 0], found[:, :, k, 1:4], found[:, :, k, 4] = (p * q).sum(axis=2), -(p + q), 1
    normal = np.cross(B - A, C - A)
    found[:, :, 6, 0], found[:, :, 6, 1:4] = (normal * A).sum(axis=2), -normal
    return found


def _far(centre: Floats, area: Floats, middle: Floats) -> Floats:
    """With the sum N of areas, and M of their products with d from the centre: r^2, N . r + tr M and -3 r^T M r."""
    N, M = area.sum(axis=1), einsum("kij,kil->kjl", area, middle - centre[:, None])
    M = (M + M.transpose(0, 2, 1)) / 2
    found = np.zeros((3, len(centre), 10))
    found[0, :, 0], found[0, :, 1:4], found[0, :, 4:7] = (centre**2).sum(axis=1), -2 * centre, 1
    found[1, :, 0], found[1, :, 1:4] = (N * centre).sum(axis=1) + np.trace(M, axis1=1, axis2=2), -N
    Mp = einsum("kij,kj->ki", M, centre)
    found[2, :, 0], found[2, :, 1:4] = (Mp * centre).sum(axis=1), -2 * Mp
    found[2, :, 4:7] = M[:, (0, 1, 2), (0, 1, 2)]
    found[2, :, 7:] = 2 * M[:, (0, 1, 2), (1, 2, 0)]
    found[2] *= -3
    return found


def _dipoles(powers: Floats, far: Floats) -> Floats:
    square, first, second = (product(part, powers) for part in far)
    second /= square
    second += first
    square *= np.sqrt(square)
    second /= square
    angles: Floats = second.sum(axis=0)
    return angles


def _triangles(powers: Floats, triangles: Floats) -> Floats:
    """Return the sum of 2 atan2(det(a, b, c), abc + (a.b) c + (b.c) a + (c.a) b)."""
    a, b, c, ab, bc, ca, depth = (product(part, powers) for part in triangles.transpose(1, 0, 2))
    for square in (a, b, c):
        np.sqrt(np.maximum(square, 0, out=square), out=square)
    ab += a * b
    ab *= c
    bc *= a
    ab += bc
    ca *= b
    ab += ca
    angles: Floats = 2 * np.arctan2(depth, ab, out=depth).sum(axis=0)
    return angles
