"""Moments of volume and of surface of a block of triangles.

A tetrahedron from the point of reference to a triangle a, b, c has six times the volume D = a . ((b - a) x (c - a)).
Over it, and over the triangle, a quadratic is the mean of its values at the middles of the three edges, times a
constant (Hammer, Marlowe, Stroud 1956). With the edge sums u = a + b, b + c, c + a:

    6 V = sum D,    24 first = sum D (a + b + c),    120 S = sum D u u^T,

and for the surface, with twice the area of a triangle |(b - a) x (c - a)| for D, 2 A, 6 first and 24 S.

Operations on rows that follow each other are the fast ones. Each triangle is added to the one half a block further on,
and the sums of NumPy's pairwise summation over these pairs are the results, which lose fewer digits than dot products
do. Those are left to what is a bound (of less than 10 000 numbers, for which OpenBLAS starts no threads).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robodyn.programs.vectors import Array
from robodyn.solids.mesh.triangles import Step, workspace

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
"""The entries of a symmetric matrix in the order of its sums."""
SUMS = 11
"""Sums of `volume_kernel` that are results, not bounds."""


class Kernel(NamedTuple):
    """Steps to be taken for every block, and the arrays that then have its sums and twice the area of each triangle."""

    steps: list[Step]
    result: Array
    sizes: Array


def volume_kernel(space: Array) -> Kernel:
    """6 V, 24 first (3), 120 S (6: xx, yy, zz, xy, yz, xz), twice the area, and about the sums of the squares of the
    coordinates of b - a (3) and c - a (3), for bounds.

    Args:
        space: (4, 3, n) of `block_space`, with corners from the point of reference; they are lost.
    """
    X, result, n = space[:3], np.empty(17, space.dtype), space.shape[-1]
    early, normal, weight = (workspace(rows, n, space.dtype) for rows in (18, 3, 1))
    sums = workspace(SUMS, n // 2, space.dtype)
    edges, terms = early[:6], early[6:9]
    steps: list[Step] = [
        *cross_steps(X, early[:12], normal),
        (np.matmul, (edges[:, None, :], edges[..., None], result[SUMS:, None, None])),
        (np.multiply, (normal, X[0], terms)),
        *_row_sum(terms, weight[0]),
        *_lengths(normal),
        _halves(normal[0], sums[10]),
        *_moments(space, weight, early, sums),
        (np.add.reduce, (sums, 1, None, result[:SUMS])),
    ]
    return Kernel(steps, result, normal[0])


def surface_kernel(space: Array) -> Kernel:
    """2 A, 6 first (3), 24 S (6), for the same space."""
    result, n = np.empty(10, space.dtype), space.shape[-1]
    early, normal, weight = (workspace(rows, n, space.dtype) for rows in (18, 3, 1))
    sums = workspace(10, n // 2, space.dtype)
    steps: list[Step] = [
        *cross_steps(space[:3], early[:12], normal),
        *_lengths(normal),
        (np.copyto, (weight[0], normal[0])),
        *_moments(space, weight, early, sums),
        (np.add.reduce, (sums, 1, None, result)),
    ]
    return Kernel(steps, result, normal[0])


def symmetric(entries: Array) -> Array:
    """(3, 3) from the entries xx, xy, xz, yy, yz, zz."""
    matrix = np.empty((3, 3), entries.dtype)
    for (i, j), entry in zip(PAIRS, entries, strict=True):
        matrix[i, j] = matrix[j, i] = entry
    return matrix


def cross_steps(X: Array, space: Array, normal: Array) -> list[Step]:
    """(b - a) x (c - a), and its products in the last six of twelve rows of space."""
    edges, (plus, minus) = space.reshape(2, 2, 3, -1)
    (ex, ey, ez), (fx, fy, fz) = edges
    return [
        (np.subtract, (X[1], X[0], edges[0])),
        (np.subtract, (X[2], X[0], edges[1])),
        (np.multiply, (ey, fz, plus[0])),
        (np.multiply, (ez, fx, plus[1])),
        (np.multiply, (ex, fy, plus[2])),
        (np.multiply, (ez, fy, minus[0])),
        (np.multiply, (ex, fz, minus[1])),
        (np.multiply, (ey, fx, minus[2])),
        (np.subtract, (plus, minus, normal)),
    ]


def _row_sum(rows: Array, out: Array) -> list[Step]:
    return [(np.add, (rows[0], rows[1], out)), (np.add, (out, rows[2], out))]


def _lengths(normal: Array) -> list[Step]:
    first = normal[0]
    return [(np.multiply, (normal, normal, normal)), *_row_sum(normal, first), (np.sqrt, (first, first))]


def _halves(rows: Array, out: Array) -> Step:
    """Add each triangle to the one half a block further on."""
    half = rows.shape[-1] // 2
    return np.add, (rows[..., :half], rows[..., half:], out)


def _moments(space: Array, weight: Array, early: Array, sums: Array) -> list[Step]:
    """Weight, weight (a + b + c) and weight u u^T for a row of weights, in the first ten rows of sums."""
    (a, b, c, third), edges = space, space[1:]
    weighted, terms = early.reshape(2, 3, 3, -1)
    whole = terms[0]
    steps: list[Step] = [
        _halves(weight[0], sums[0]),
        (np.add, (a, b, third)),
        (np.add, (third, c, whole)),
        (np.multiply, (whole, weight, whole)),
        _halves(whole, sums[1:4]),
        (np.add, (b, c, b)),
        (np.add, (c, a, c)),
        (np.multiply, (edges, weight, weighted)),
    ]
    first = 4
    for apart in range(3):  # the entries i, i + apart, for which PAIRS is in this order
        some = terms[:, : 3 - apart]
        steps += [
            (np.multiply, (weighted[:, : 3 - apart], edges[:, apart:], some)),
            *_row_sum(some, some[0]),
            _halves(some[0], sums[first : first + 3 - apart]),
        ]
        first += 3 - apart
    return steps
