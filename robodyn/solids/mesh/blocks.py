"""Corners of triangles as rows of one coordinate each, in blocks of one size that stay in the cache."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from robodyn.programs.vectors import Array
from robodyn.solids.mesh.triangles import Triangles

CHUNK = 256
"""Numbers that one dot product adds up: few, because the rounding errors of equal terms do not cancel."""

ROWS = 17 * CHUNK
"""Triangles of a block: enough to hide what a call of NumPy costs, few enough for the second-level cache."""

_BITS = 3

Step = tuple[Callable[..., Any], tuple[Any, ...]]
"""A function and its arguments: rows of workspaces, which are written to. What is ready to be called costs less."""


def rows_for(count: int) -> int:
    """Triangles of a block of a mesh with so many: a multiple of CHUNK."""
    return min(max(-(-count // CHUNK), 1) * CHUNK, ROWS)


def workspace(rows: int, columns: int, dtype: DTypeLike = np.float64) -> Array:
    """(rows, columns) numbers that start on a cache line."""
    kind: np.dtype[Any] = np.dtype(dtype)
    size = rows * columns * kind.itemsize
    raw = np.empty(size + 64, np.uint8)
    first = -int(raw.__array_interface__["data"][0]) % 64
    return raw[first : first + size].view(kind).reshape(rows, columns)


def block_space(triangles: Triangles, dtype: DTypeLike = np.float64) -> Array:
    """(4, 3 coordinates, n): three corners of each triangle of a block, and as many rows to spare."""
    n = rows_for(triangles.count)
    return workspace(12, n, dtype).reshape(4, 3, n)


def fill(space: Array, triangles: Triangles, checked: bool = True) -> Iterator[Array]:
    """Put one block after the other into the same space, which may be written to in between.

    Where triangles do not fill it the rest is one corner of the mesh three times over: a triangle that adds nothing to
    any sum, box or boundary.

    Args:
        checked: False where the caller sees for itself that corners are finite, which saves time with a streamed file.

    Returns:
        (3 corners, 3 coordinates, n) in units of the file, part of the space.
    """
    X = space[:3]
    as_given = X.transpose(2, 0, 1)
    rows = X.shape[-1]
    for block in (triangles.blocks if checked else triangles.records)(rows):
        as_given[: len(block)] = block
        X[:, :, len(block) :] = X[:1, :, :1]
        yield X


def reference_in(X: Array) -> Array:
    """The centre of the box around a block, rounded to a few bits of its size, so that subtracting it is mostly exact.

    Args:
        X: (3 corners, 3 coordinates, n).

    Returns:
        (3,) inside the box.
    """
    lo, hi = X.min(axis=(0, 2)), X.max(axis=(0, 2))
    with np.errstate(all="ignore"):
        _, exponent = np.frexp(hi - lo)
        quantum = np.ldexp(1.0, exponent - _BITS)
        centre = np.rint((lo / 2 + hi / 2) / quantum) * quantum
    inside = (lo < centre) & (centre < hi)
    reference: Array = np.where(inside, centre, lo).astype(np.float64) + 0.0
    return reference
