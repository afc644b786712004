"""Whether an orthogonal map takes the triangles of a mesh to each other."""

from __future__ import annotations

import numpy as np

from robodyn.programs.vectors import Array, product

_BITS = 30
_SHIFT = 0.3819660113
_FACTORS = tuple(map(np.uint64, (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)))
_HALF = np.uint64(29)


class TriangleSet:
    """The triangles (m, 3, 3) of a mesh as a set, with corners rounded to 2^-30 of their largest distance."""

    def __init__(self, corners: Array, reach: float) -> None:
        self._X = np.ascontiguousarray(corners.T)
        self._scale = 2.0**_BITS / reach
        self._sum = self._hash(self._X)

    def invariant(self, Q: Array) -> bool:
        """Whether Q, about the origin, takes every triangle to one of the set, whatever the order of its corners.

        Sets are told apart by a sum of 64 bits. Corners that are rounded differently make sets differ that do not; a
        set that is called invariant is so within the rounding.
        """
        return self._hash(product(Q, self._X.reshape(3, -1)).reshape(self._X.shape)) == self._sum

    def _hash(self, X: Array) -> int:
        """The sum over the triangles (3 coordinates, 3 corners, m) of a mix of the sum of a mix of each corner."""
        places = np.floor(X * self._scale + _SHIFT).astype(np.int64).view(np.uint64)
        words = places[0] * _FACTORS[0]
        for i in (1, 2):
            words = (words ^ (words >> _HALF)) * _FACTORS[i] + places[i] * _FACTORS[i - 1]
        words = (words ^ (words >> _HALF)) * _FACTORS[0]
        triangles = (words[0] + words[1] + words[2]) * _FACTORS[1]
        return int(((triangles ^ (triangles >> _HALF)) * _FACTORS[2]).sum())
