"""Moments of a volume above the second order, and how far a body is from its images."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import comb, pi

import numpy as np

from robodyn.errors import MeshError
from robodyn.programs.vectors import IDENTITY, Array, length, product, rotation_about
from robodyn.solids.mesh.columns import COLUMNS, Lattice, differing_volume, frame_along
from robodyn.solids.mesh.indexed import hashed
from robodyn.solids.mesh.integrals import Integrals
from robodyn.solids.mesh.tessellation import LineMasses, line_masses
from robodyn.solids.mesh.triangles import Triangles
from robodyn.support.floats import Floats

FREQUENCIES = 8
"""Highest order of the moments about an axis."""
_HEIGHTS = 3
_BLOCK, _SMALL_BLOCK = 2048, 512
_UPPER = np.triu_indices(3)
_NEAR, _FAR = 0.091576213509770743, 0.44594849091596489
_SHARES = np.array([np.roll((1 - 2 * s, s, s), turn) for s in (_NEAR, _FAR) for turn in range(3)])
_WEIGHTS = np.repeat((0.10995174365532187, 0.22338158967801147), 3)
"""The rule with six points for the mean over a triangle, exact for the fourth order (Cowper 1973)."""
_PAIR = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])


@dataclass(frozen=True, eq=False)
class CentralMoments:
    """Integrals over a volume of x x, x x x and x x x x about its centre; reach: the largest distance of a corner."""

    volume: float
    reach: float
    tensors: tuple[Array, Array, Array]

    def least_asymmetry(self, Q: Array) -> float:
        """Return a lower bound of vol(A xor Q A) / 2V, for an orthogonal map Q about the centre. |M - Q M| <= vol(A xor
        Q A) max|f|, for the moment M of each product f of coordinates."""
        bound = 0.0
        for order, M in enumerate(self.tensors, start=2):
            image = M
            for _ in range(order):
                image = product(image.reshape(3, -1).T, Q.T)
            bound = max(bound, float(np.abs(M - image.reshape(M.shape)).max()) / (2 * self.volume * self.reach**order))
        return bound


def central_moments(corners: Array, S: Array, volume: float) -> CentralMoments:
    """Return the moments of the third and fourth order, with those of the second as given.

    Over the tetrahedron from the centre to a triangle a product of k coordinates is D / (2k + 6) times its mean over
    the triangle, with D six times the volume of the tetrahedron: the mean by a rule that is exact. Corners (m, 3, 3)
    and S, the integral of x x^T, are about the centre.
    """
    third, fourth = np.zeros((6, 3)), np.zeros((6, 6))
    for start in range(0, len(corners), _BLOCK):
        block = corners[start : start + _BLOCK]
        X = product(_SHARES, block).transpose(2, 1, 0).reshape(3, -1)
        pairs = np.stack([X[i] * X[j] for i, j in zip(*_UPPER, strict=True)])
        weighted = pairs * np.outer(_WEIGHTS, determinants(block)).ravel()
        third += product(weighted, X.T)
        fourth += product(weighted, pairs.T)
    tensors = S, third[_PAIR] / 12, fourth[_PAIR][:, :, _PAIR] / 14
    return CentralMoments(volume, float(np.sqrt((corners**2).sum(axis=2).max())), tensors)


def axial_moments(corners: Array, frame: Array, volume: float) -> Array:
    """(8, 3) complex: integrals of (x + iy)^m z^k over the volume, m = 1 .. 8, k = 0 .. 2, m + k <= 8 (others zero).

    A rotation about z by an angle a turns them by m a. They are relative to V and the largest values of |x + iy|^m and
    |z|^k among the corners. Rows of the frame are x, y, z.

    The integral over a tetrahedron of the power m of a linear function is D m! / (m + 3)! h_m, with h_m the sum of all
    products of degree m of its values at the corners. With w + e z for the function, w = x + iy, the factor of e^k is
    that of w^(m - k) z^k times m over k.
    """
    local = product(corners, frame.T)
    radius, height = np.hypot(local[..., 0], local[..., 1]).max(), np.abs(local[..., 2]).max()
    local = local / (radius, radius, height)
    found = np.zeros((FREQUENCIES, _HEIGHTS), dtype=complex)
    for start in range(0, len(local), _BLOCK):
        block = local[start : start + _BLOCK]
        x, y, z = block.transpose(2, 1, 0)
        w, D = x + 1j * y, determinants(block)
        jets = np.zeros((3, _HEIGHTS, len(D)), dtype=complex)
        jets[:, 0] = 1.0
        for degree in range(1, FREQUENCIES + 1):
            for corner in range(3):
                grown = w[corner] * jets[corner]
                grown[1:] += z[corner] * jets[corner, :-1]
                jets[corner] = grown if corner == 0 else grown + jets[corner - 1]
            share = 1.0 / ((degree + 1) * (degree + 2) * (degree + 3))
            for k in range(min(degree, _HEIGHTS)):
                found[degree - k - 1, k] += share * product(jets[2, k], D) / comb(degree, k)
    relative: Array = found * (radius**2 * height / volume)
    return relative


def determinants(corners: Array) -> Floats:
    """Six times the volumes of the tetrahedra from the origin."""
    a, b, c = corners.transpose(1, 2, 0)
    D = np.zeros(len(corners))
    for i in range(3):
        D += a[i] * (b[i - 2] * c[i - 1] - b[i - 1] * c[i - 2])
    return D


def sixth_moments(corners: Array) -> Array:
    """(3, 3, 3, 3, 3, 3) integrals of products of six coordinates over the tetrahedra from the origin to triangles.
    Lengths are in units of the largest distance of a corner."""
    reach = np.sqrt((corners**2).sum(axis=2).max())
    sums = np.zeros((27, 27))
    for start in range(0, len(corners), _SMALL_BLOCK):
        block = corners[start : start + _SMALL_BLOCK] / reach
        X = product(_FOLDED, block).transpose(2, 1, 0).reshape(3, -1)
        triples = (X[:, None, None] * X[:, None] * X).reshape(27, -1)
        sums += product(triples * np.outer(_FOLDED_WEIGHTS, determinants(block)).ravel(), triples.T)
    return (sums / 9).reshape((3,) * 6)


def _folded() -> tuple[Floats, Floats]:
    """Shares (16, 3) of the corners of a triangle and weights (16,): Gauss's rule of four points, exact to degree 7,
    in each direction of a square that is folded to a triangle of area 1/2 (Duffy)."""
    near, far = np.sqrt(3 / 7 - 2 / 7 * np.sqrt(6 / 5)), np.sqrt(3 / 7 + 2 / 7 * np.sqrt(6 / 5))
    x = (1 + np.array((-far, -near, near, far))) / 2
    outer, inner = (18 - np.sqrt(30.0)) / 72, (18 + np.sqrt(30.0)) / 72
    w = np.array((outer, inner, inner, outer))
    u, v = np.repeat(x, 4), np.tile(x, 4)
    b, c = u, v * (1 - u)
    return np.stack([1 - b - c, b, c], axis=1), np.repeat(w * (1 - x), 4) * np.tile(w, 4)


_FOLDED, _FOLDED_WEIGHTS = _folded()


_BITS = 30
_HASH_BLOCK = 1 << 14
_SHIFT = 0.3819660113
_MIX = np.uint64(0xBF58476D1CE4E5B9)
_HALF = np.uint64(32)


class TriangleSet:
    """The triangles (m, 3, 3) of a mesh as a set, with corners rounded to 2^-30 of their largest distance."""

    def __init__(self, corners: Array, reach: float) -> None:
        self._corners = corners
        self._scale = 2.0**_BITS / reach
        self._sum = self._total(IDENTITY)

    def invariant(self, Q: Array) -> bool:
        """Whether Q, about the origin, takes every triangle to one of the set, within the rounding."""
        return self._total(Q) == self._sum

    def _total(self, Q: Array) -> int:
        """Return the sum over all triangles of a mix of the sum of a mix of each corner."""
        total = 0
        for start in range(0, len(self._corners), _HASH_BLOCK):
            X = np.ascontiguousarray(self._corners[start : start + _HASH_BLOCK].T)
            X = X if Q is IDENTITY else product(Q, X.reshape(3, -1)).reshape(X.shape)
            triangles = hashed(np.floor(X * self._scale + _SHIFT).transpose(1, 0, 2)).sum(axis=0) * _MIX
            total += int(((triangles ^ (triangles >> _HALF)) * _MIX).sum())
        return total % 2**64


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
    """A closed mesh about its centre of mass, wound outwards; S: (3, 3) integral of x x^T."""

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
        masses = self.line_masses
        return float(np.abs(masses.missing[masses.fine]).sum()) / self.volume

    @cached_property
    def _set(self) -> TriangleSet:
        return TriangleSet(self.corners, self.moments.reach)

    def same(self, Q: Array) -> bool:
        """Return whether an orthogonal map takes the triangles to each other."""
        return self.moments.least_asymmetry(Q) <= _SAME and self._set.invariant(Q)

    def mirrored(self, normal: Array) -> float:
        """vol(A xor M A) / 2V for the mirror image in the plane through the centre, by columns along the normal."""
        least = max(self.moments.least_asymmetry(mirror(normal)), self.product_bound(normal))

        def by_columns(count: int) -> float:
            lattice = Lattice.over(self.corners, normal, count=count)
            hits = lattice.hits(self.corners)
            return differing_volume(hits, hits._replace(depth=-hits.depth, sign=-hits.sign), lattice.cell)

        return self._asymmetry(mirror(normal), least, by_columns)

    def turned(self, axis: Array, angle: float) -> float:
        """vol(A xor R A) / 2V for a rotation about an axis through the centre."""
        Q = rotation_about(axis, angle)
        oblique = product(_OBLIQUE, frame_along(axis))  # along the axis columns would pass by two thin rims

        def by_columns(count: int) -> float:
            lattice = Lattice.over(self.corners, oblique, Q, count)
            images = replace(lattice, frame=product(lattice.frame, Q))  # its columns go through A as these through Q A
            return differing_volume(lattice.hits(self.corners), images.hits(self.corners), lattice.cell)

        return self._asymmetry(Q, self.moments.least_asymmetry(Q), by_columns)

    def revolved(self, axis: Array) -> float:
        """Return the largest of a few rotations by angles that are far from all simple parts of a turn."""
        worst = 0.0
        for times in (1, 2, 3):
            worst = max(worst, self.turned(axis, GOLDEN_TURN * times))
            if worst > COARSE:
                break
        return worst

    def _asymmetry(self, Q: Array, least: float, by_columns: Callable[[int], float]) -> float:
        """Return the moments' bound for the same triangles; else by few columns, or by many where few do not tell."""
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
        """|integral of x n dV| / (V max|x| max|n|), which the asymmetry is not below, for the worst x in the plane."""
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
