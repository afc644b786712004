"""How much of a body its facets may leave out or add, for telling facets from true asymmetry."""

from __future__ import annotations

from math import radians

import numpy as np

from robodyn.spatial import Array

_SHARPEST = radians(40)
_FLAT = 1e-5
_TIMES_MEDIAN = 3
_FACTORS = tuple(map(np.uint64, (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)))
_HALF = np.uint64(32)


def facet_volume(corners: Array) -> float:
    """The volume between the facets and the smooth surface they may stand for, whatever its sign.

    For each edge of length l between two triangles of heights h1, h2 that meet at a dihedral angle th below 40 degrees
    and three times the median one: l h_i^2 t_i / 24 on either side, with t_i = 2 th h_i / (h1 + h2).

    Args:
        corners: (m, 3, 3); an edge has the same bits in both its triangles.
    """
    start, following = corners.reshape(-1, 3), corners[:, [1, 2, 0]].reshape(-1, 3)
    one, other = _pairs(start, following)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(following[one] - start[one], axis=1)
    first, second = normal[one // 3], normal[other // 3]
    angle = np.arctan2(np.linalg.norm(np.cross(first, second), axis=1), np.einsum("ij,ij->i", first, second))
    bent = (angle > _FLAT) & (angle < _SHARPEST) & (length > 0)
    if not bent.any():
        return 0.0
    smooth = bent & (angle < _TIMES_MEDIAN * np.median(angle[bent]))
    l, th = length[smooth], angle[smooth]
    h1, h2 = (np.linalg.norm(side[smooth], axis=1) / l for side in (first, second))
    return float((l * th * (h1**3 + h2**3) / (h1 + h2)).sum() / 12)


def _pairs(start: Array, following: Array) -> tuple[Array, Array]:
    """The numbers of edges that are the same pair of corners, where just two are."""
    key = _hashed(start) + _hashed(following)
    order = np.argsort(key)
    ordered = key[order]
    first = np.concatenate([[True], ordered[1:] != ordered[:-1], [True]])
    (begin,) = np.nonzero(first)
    (twice,) = np.nonzero(np.diff(begin) == 2)
    return order[begin[twice]], order[begin[twice] + 1]


def _hashed(points: Array) -> Array:
    bits = (points + 0.0).view(np.uint64)
    words = bits[:, 0] * _FACTORS[0]
    for i in (1, 2):
        words = ((words ^ (words >> _HALF)) + bits[:, i]) * _FACTORS[i]
    return words ^ (words >> _HALF)
