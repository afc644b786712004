"""How far a body is from its images."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np

from robodyn.errors import MeshError
from robodyn.programs.vectors import IDENTITY, Array, length, product, rotation_about
from robodyn.solids.mesh.integrate.integrals import Integrals
from robodyn.solids.mesh.region.columns import COLUMNS, Lattice, differing_volume, frame_along
from robodyn.solids.mesh.symmetry.higher_moments import CentralMoments, central_moments
from robodyn.solids.mesh.tessellation.lines import LineMasses, line_masses
from robodyn.solids.mesh.triangles import Triangles
from robodyn.support.floats import Floats

_BITS = 30
_BLOCK = 1 << 14
_SHIFT = 0.3819660113
_FACTORS = tuple(map(np.uint64, (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)))
_HALF = np.uint64(29)


class TriangleSet:
    """The triangles (m, 3, 3) of a mesh as a set, with corners rounded to 2^-30 of their largest distance."""

    def __init__(self, corners: Array, reach: float) -> None:
        self._corners = corners
        self._scale = 2.0**_BITS / reach
        self._sum = self._total(IDENTITY)

    def invariant(self, Q: Array) -> bool:
        """Whether Q, about the origin, takes every triangle to one of the set, whatever the order of its corners.

        Sets are told apart by a sum of 64 bits. Corners that are rounded differently make sets differ that do not; a
        set that is called invariant is so within the rounding.
        """
        return self._total(Q) == self._sum

    def _total(self, Q: Array) -> int:
        """The sum over all triangles, turned by Q, modulo 2^64."""
        total = 0
        for start in range(0, len(self._corners), _BLOCK):
            X = np.ascontiguousarray(self._corners[start : start + _BLOCK].T)
            total += self._hash(X if Q is IDENTITY else product(Q, X.reshape(3, -1)).reshape(X.shape))
        return total % 2**64

    def _hash(self, X: Array) -> int:
        """The sum over the triangles (3 coordinates, 3 corners, n) of a mix of the sum of a mix of each corner."""
        places = np.floor(X * self._scale + _SHIFT).astype(np.int64).view(np.uint64)
        words = places[0] * _FACTORS[0]
        for i in (1, 2):
            words = (words ^ (words >> _HALF)) * _FACTORS[i] + places[i] * _FACTORS[i - 1]
        words = (words ^ (words >> _HALF)) * _FACTORS[0]
        triangles = (words[0] + words[1] + words[2]) * _FACTORS[1]
        return int(((triangles ^ (triangles >> _HALF)) * _FACTORS[2]).sum())


GOLDEN_TURN = pi * (3 - 5**0.5)

COARSE = 0.03
"""Above this an asymmetry need not be known well."""

_SAME = 1e-6
"""Moments of the same triangles differ by less."""

_TINY = 1e-8

_CLEAR = 1.5

_OBLIQUE = np.array((0.48, 0.6, 0.64))


@dataclass(frozen=True, eq=False)
class CentredBody:
    """A closed mesh about its centre of mass, wound outwards.

    Attributes:
        corners: (m, 3, 3) about the centre.
        centre: (3,) in units of the file. volume: positive.
        S: (3, 3) integral of x x^T about the centre.
    """

    corners: Floats
    centre: Floats
    volume: float
    S: Floats

    @classmethod
    def of(cls, triangles: Triangles, integrals: Integrals) -> CentredBody:
        """Raises MeshError where there is no volume."""
        V = integrals.volume
        if not V:
            raise MeshError("has no volume", remedy="symmetry is that of a closed mesh", file=triangles.name)
        shift = integrals.first / V
        S = (integrals.S - np.outer(integrals.first, shift)) * np.sign(V)
        corners = triangles.array()
        corners -= integrals.reference
        corners -= shift
        return cls(corners if V > 0 else corners[:, ::-1], integrals.reference + shift, abs(V), S)

    @cached_property
    def moments(self) -> CentralMoments:
        return central_moments(self.corners, self.S, self.volume)

    @cached_property
    def line_masses(self) -> LineMasses:
        """What facets leave out, about the centre."""
        return line_masses(self.corners)

    @property
    def facets(self) -> float:
        """The volume between facets and the surface they may stand for, as a part of the volume."""
        return self.line_masses.size / self.volume

    @cached_property
    def _set(self) -> TriangleSet:
        return TriangleSet(self.corners, self.moments.reach)

    def same(self, Q: Array) -> bool:
        """Return whether an orthogonal map takes the triangles to each other."""
        return self.least(Q) <= _SAME and self._set.invariant(Q)

    def least(self, Q: Array) -> float:
        """Return a lower bound of the asymmetry under an orthogonal map, by moments."""
        return self.moments.least_asymmetry(Q)

    def mirrored(self, normal: Array) -> float:
        """vol(A xor M A) / 2V for the mirror image in the plane through the centre.

        By columns along the normal, which the mirror takes to themselves; and not less than the moments allow.
        """
        least = max(self.least(mirror(normal)), self.product_bound(normal))

        def by_columns(count: int) -> float:
            lattice = Lattice.over(self.corners, normal, count=count)
            hits = lattice.hits(self.corners)
            return differing_volume(hits, hits.reflected(0.0), lattice.cell)

        return self._asymmetry(mirror(normal), least, by_columns)

    def turned(self, axis: Array, angle: float) -> float:
        """vol(A xor R A) / 2V for a rotation about an axis through the centre.

        The columns are oblique to the axis: along it they would pass by the difference of two thin rims.
        """
        Q = rotation_about(axis, angle)
        oblique = product(_OBLIQUE, frame_along(axis))

        def by_columns(count: int) -> float:
            lattice = Lattice.over(self.corners, oblique, Q, count)
            return differing_volume(lattice.hits(self.corners), lattice.seen_by(Q).hits(self.corners), lattice.cell)

        return self._asymmetry(Q, self.least(Q), by_columns)

    def revolved(self, axis: Array) -> float:
        """Return the largest of a few rotations by angles that are far from all simple parts of a turn."""
        worst = 0.0
        for times in (1, 2, 3):
            worst = max(worst, self.turned(axis, GOLDEN_TURN * times))
            if worst > COARSE:
                break
        return worst

    def _asymmetry(self, Q: Array, least: float, by_columns: Callable[[int], float]) -> float:
        """Return the moments' bound for the same set of triangles; else by columns.

        By few if they find much, unless triangles cost more than columns; by many unless the difference is clearly one
        that facets make.
        """
        if self.same(Q):
            return least
        if len(self.corners) <= COLUMNS:
            rough = by_columns(COLUMNS // 4) / (2 * self.volume)
            if rough > COARSE:
                return max(least, rough)
        fine = by_columns(COLUMNS) / (2 * self.volume)
        if _TINY < fine < COARSE / 2 and not _CLEAR * fine < self.facets:
            fine = by_columns(4 * COLUMNS) / (2 * self.volume)
        return max(least, fine)

    def product_bound(self, normal: Array) -> float:
        """|integral of x n dV| / (V max|x| max|n|), which the asymmetry is not below, for the worst direction x.

        x is the direction in the plane along which the product of inertia with the normal n is all of it.
        """
        mixed = product(self.S, normal)
        mixed = mixed - normal * product(normal, mixed)
        size = length(mixed)
        if size <= 1e-14 * abs(float(np.trace(self.S))):
            return 0.0
        reach = np.abs(product(self.corners, np.stack([mixed / size, normal], axis=1))).max(axis=(0, 1))
        return size / (self.volume * float(reach[0] * reach[1]))


def mirror(normal: Array) -> Floats:
    """Return the reflection 1 - 2 n n^T."""
    reflection: Floats = IDENTITY - 2 * np.outer(normal, normal)
    return reflection
