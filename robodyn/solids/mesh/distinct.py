"""Equal keys and equal points given one number, by a single sort of words."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats

Numbers = NDArray[np.signedinteger[Any]]

_FACTORS = tuple(map(np.uint64, (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)))
_HALF = np.uint64(32)
_WORD = 63
_FEW_BITS = 18
"""Bits of the number of points up to which the rest of a word tells them apart, but for one set in a thousand."""


class Distinct(NamedTuple):
    """Values without repetition, in their order: the first place of each, and of each place the number of its value."""

    first: Numbers
    of: Numbers


def distinct(keys: Numbers) -> Distinct:
    """Return what `np.unique` finds of keys (n,) from 0 to 2^63 - 1.

    Method: words of a key and its place are sorted, where both fit; that takes a fifth of the time of sorting places.
    """
    bits = len(keys).bit_length()
    if int(keys.max(initial=0)) >> (_WORD - bits):
        order: Numbers = np.argsort(keys, kind="stable")
        ordered = keys[order]
    else:
        words = (keys << bits) | np.arange(len(keys))
        words.sort()
        order, ordered = words & ((1 << bits) - 1), words >> bits
    new = np.ones(len(keys), np.bool_)
    np.not_equal(ordered[1:], ordered[:-1], out=new[1:])
    of = np.empty(len(keys), np.int64)
    of[order] = np.cumsum(new) - 1
    return Distinct(order[new], of)


def numbered(names: Numbers, most: int) -> tuple[int, Numbers]:
    """Return how many different names (n,) from 0 to most - 1 there are, and the number of each in their order."""
    there = np.zeros(most, np.bool_)
    there[names] = True
    number = np.cumsum(there)
    return int(number[-1]) if most else 0, number[names] - 1


def distinct_points(points: Floats) -> Distinct:
    """Return the different points of (n, 3), none of which is -0 or no number, ordered by x, then y, then z.

    Method: points of the same hash are compared bit by bit; were two different ones among them, all would be sorted.
    """
    bits = len(points).bit_length()
    hashes = hashed(np.ascontiguousarray(points.T)[None])[0] >> np.uint64(1 + (bits if bits <= _FEW_BITS else 0))
    first, of = distinct(hashes.view(np.int64))
    found = points[first]
    if (found[of] != points).any():
        return _distinct_by_coordinates(points)
    order = np.lexsort(found.T[::-1])
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return Distinct(first[order], place[of])


def _distinct_by_coordinates(points: Floats) -> Distinct:
    found = Distinct(np.zeros(0, np.int64), np.zeros(len(points), np.int64))
    for coordinate in points.T:
        _, place = np.unique(coordinate, return_inverse=True)
        found = distinct(found.of * (int(place.max(initial=0)) + 1) + place)
    return found


def hashed(X: Floats) -> NDArray[np.uint64]:
    """(k, m) of points (k, 3 coordinates, m), mixed so well that the sums for sides of a rectangle differ."""
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
