"""Which edges of triangles are the same."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import Array

Integers = NDArray[np.int64]

_FACTORS = tuple(map(np.uint64, (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)))
_HALF = np.uint64(32)
_LOW = np.uint64(2**32 - 1)


def paired_edges(X: Array) -> tuple[Integers, Integers]:
    """The numbers, triangle plus m times corner, of edges that are the same pair of corners, where just two are.

    In ascending order, so that what they refer to is read nearly in order as well.

    Method: keys that hold as many bits of the hash of an edge as its number leaves free, so that one sort without an
    index brings equal edges together. Where two edges share a key, which of a million triangles happens to about one
    edge, neither is found.

    Args:
        X: (3 corners, 3 coordinates, m) with the same bits in both triangles of an edge.
    """
    hashes = _hashed(X)
    keys = np.concatenate([hashes[i - 3] + hashes[i - 2] for i in range(3)])
    low = np.uint64((1 << (len(keys) - 1).bit_length()) - 1)
    keys &= ~low
    keys |= np.arange(len(keys), dtype=np.uint64)
    keys.sort()
    edge = keys & ~low
    same = np.concatenate([[False], edge[1:] == edge[:-1], [False]])
    (begin,) = np.nonzero(~same[:-2] & same[1:-1] & ~same[2:])
    keys &= low
    both = (keys[begin] << _HALF) | keys[begin + 1]
    both.sort()
    return (both >> _HALF).view(np.int64), (both & _LOW).view(np.int64)


def _hashed(X: Array) -> NDArray[np.uint64]:
    """Of each corner, mixed so well that the sums for the sides of a rectangle differ."""
    bits = (X + 0.0).view(np.uint64)
    words: NDArray[np.uint64] = bits[:, 0] * _FACTORS[0]
    for i in (1, 2):
        words ^= words >> _HALF
        words += bits[:, i]
        words *= _FACTORS[i]
    for factor in _FACTORS[:2]:
        words ^= words >> _HALF
        words *= factor
    words ^= words >> _HALF
    return words
