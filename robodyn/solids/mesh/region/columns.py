"""Columns through closed surfaces: volumes by scan lines, exact in depth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, cos, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import IDENTITY, Array, length, product
from robodyn.support.floats import Floats, first_largest

Integers = NDArray[np.int64]

COLUMNS = 4096
"""Columns over the shadow's box."""

_GOLDEN = (sqrt(5) - 1) / 2
_BELOW_ONE = 1 - 2.0**-20
_TURN = 0.6180339887
"""Angle between the rows and the coordinate axes, so that the edges of a part do not lie along them."""


_ORDERS = np.array([(0, 1, 2), (1, 0, 2), (0, 2, 1), (0, 1, 2), (0, 1, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)]).T
"""Corners in ascending order, by whether 0 > 1, 1 > 2 and 0 > 2 as bits 1, 2 and 4."""

_DOWN = np.where((_ORDERS[1] - _ORDERS[0]) % 3 == 1, -1, 1)
"""-1 where that order is the one of the winding."""


class Hits(NamedTuple):
    """Where columns meet a surface: the number of the column, the depth, and +1 (into the body) or -1 (out of it)."""

    column: Integers
    depth: Floats
    sign: Integers

    def reflected(self, offset: float) -> Hits:
        """Return those of the mirror image in the plane at this depth, which takes every column to itself."""
        return Hits(self.column, 2 * offset - self.depth, -self.sign)


@dataclass(frozen=True, eq=False)
class Lattice:
    """Parallel columns: rows of them at equal distances, each row shifted by the golden ratio against the last.

    Attributes:
        frame: (3, 3) orthonormal rows: along a row, across the rows, along the columns.
        corner: (2,) of the rectangle that is covered, in the first two axes of the frame.
        step: between rows, and between the columns of a row.
        rows, across: their number, and that of the columns of each.
    """

    frame: Floats
    corner: Floats
    step: float
    rows: int
    across: int

    @classmethod
    def over(cls, corners: Floats, direction: Array, image: Array = IDENTITY, count: int = COLUMNS) -> Lattice:
        """About `count` columns along a unit vector, over the shadows of points (..., 3) and of their image.

        Args:
            image: (3, 3) orthogonal.
        """
        frame = frame_along(direction)
        shadows = [frame[:2]] if image is IDENTITY else [frame[:2], product(frame, image)[:2]]
        along = [[_along(corners.T, axis) for axis in axes] for axes in shadows]
        corner = np.min([[u.min() for u in shadow] for shadow in along], axis=0)
        width, height = (np.max([[u.max() for u in shadow] for shadow in along], axis=0) - corner).tolist()
        step = sqrt(width * height / count) or max(width, height) or 1.0
        return cls(frame, corner, step, ceil(height / step) + 1, ceil(width / step) + 2)

    def seen_by(self, Q: Array) -> Lattice:
        """Return the lattice whose columns go through a body as these go through its image Q x."""
        return replace(self, frame=product(self.frame, Q))

    @property
    def cell(self) -> float:
        """The area that each column stands for."""
        return self.step**2

    def places(self, column: Integers) -> tuple[Floats, Floats]:
        """Coordinates of columns along and across the rows."""
        line, place = np.divmod(column, self.across)
        shift = np.modf(_GOLDEN * line)[0]
        return self.corner[0] + (place + 1 - shift) * self.step, self.corner[1] + (line + 0.5) * self.step

    def hits(self, corners: Floats) -> Hits:
        """Return where the columns meet triangles (m, 3, 3).

        Which columns an edge has on its left is decided once for the edge, and so the same way in both its triangles:
        the signs of each column add up to zero on every closed surface.
        """
        X = corners.T
        v = _along(X, self.frame[1])
        row = np.clip(np.floor((v - self.corner[1]) / self.step + 0.5), 0, self.rows).astype(np.int32)
        (met,) = np.nonzero((row[0] != row[1]) | (row[0] != row[2]))
        row, X, count = row.take(met, axis=1), X.take(met, axis=2), len(met)
        case = (row[0] > row[1]) + 2 * (row[1] > row[2]).view(np.uint8) + 4 * (row[0] > row[2]).view(np.uint8)
        place = _ORDERS.take(case, axis=1) * count + np.arange(count)
        row = row.ravel().take(place)
        points = np.stack([part.ravel().take(place) for part in (*(_along(X, a) for a in self.frame[::2]), v[:, met])])
        which, step = _counted(row[2] - row[0])
        line = row[0].take(which) + step
        height = self.corner[1] + (line + 0.5) * self.step
        low = (line >= row[1].take(which)) * count + which
        flat = points.reshape(3, -1)
        long = _at(points[:, 0].take(which, axis=1), points[:, 2].take(which, axis=1), height)
        short = _at(flat.take(low, axis=1), flat.take(low + count, axis=1), height)
        return self._within(long, short, line, _DOWN.take(case.take(which)))

    def _within(self, long: Floats, short: Floats, line: Integers, sign: Integers) -> Hits:
        """Columns between the two edges of a triangle on a line; each edge is given as rows (along, depth)."""
        shift = np.modf(_GOLDEN * line)[0]
        first, second = (
            np.floor((edge[0] - self.corner[0]) / self.step + shift).astype(np.int64) for edge in (long, short)
        )
        which, step = _counted(np.abs(second - first))
        column = np.minimum(first, second)[which] + step
        place = self.corner[0] + (column + 1 - shift[which]) * self.step
        (u, depth), (u_other, depth_other) = long[:, which], short[:, which]
        part = np.clip((place - u) / (u_other - u), 0.0, 1.0)
        found = depth + part * (depth_other - depth)
        leads = (first < second)[which]
        return Hits(column + self.across * line[which], found, np.where(leads, sign[which], -sign[which]))


def differing_volume(one: Hits, other: Hits, cell: float) -> float:
    """vol(A xor B), of the same columns through the closed surfaces of A and B.

    A body is where the winding number of its surface is positive. Along a column the integral is exact; across, it is
    a sum over the columns.
    """
    column, depth = np.concatenate([one.column, other.column]), np.concatenate([one.depth, other.depth])
    order = in_order(column, depth)
    of_one = np.concatenate([one.sign, np.zeros_like(other.sign)])[order]
    of_other = np.concatenate([np.zeros_like(one.sign), other.sign])[order]
    differ = (np.cumsum(of_one) > 0) != (np.cumsum(of_other) > 0)
    return cell * float(np.diff(depth[order])[differ[:-1]].sum())


def frame_along(direction: Array) -> Floats:
    """Orthonormal rows, the last along a unit vector, the others in no special position to the coordinate axes."""
    nearest = np.eye(3)[first_largest(-np.abs(direction), noise=1e-9)]
    across = np.cross(direction, nearest)
    across /= length(across)
    other = np.cross(direction, across)
    c, s = cos(_TURN), sin(_TURN)
    return np.array([c * across + s * other, c * other - s * across, direction])


def in_order(column: Integers, depth: Floats) -> Integers:
    """By column, and in each by depth, but for depths that differ by less than 1e-11 of their range."""
    if not len(depth):
        return column
    least = depth.min()
    keys = column + (depth - least) * (_BELOW_ONE / (float(depth.max() - least) or 1.0))
    return np.argsort(keys, kind="stable")


def _along(X: Floats, axis: Floats) -> Floats:
    """Products of points (3, ...) with a vector: equal for equal points, as a matrix product need not be."""
    along: Floats = X[0] * axis[0] + X[1] * axis[1] + X[2] * axis[2]
    return along


def _at(start: Floats, end: Floats, height: Floats) -> Floats:
    """Return the first two rows of points, interpolated at a height between those of the third rows."""
    between: Floats = start[:2] + (height - start[2]) / (end[2] - start[2]) * (end[:2] - start[:2])
    return between


def _counted(counts: Integers) -> tuple[Integers, Integers]:
    """For counts 2, 0, 3: 0 0 2 2 2 and 0 1 0 1 2."""
    which = np.repeat(np.arange(len(counts)), counts)
    first = np.cumsum(counts) - counts
    return which, np.arange(len(which)) - first[which]
