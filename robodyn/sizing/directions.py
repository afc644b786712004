"""Convex functions of a direction, bounded from above on a lattice: the arithmetic of `envelope`.

The weight of what a joint carries turns it by `tau = w . h`: h the first moment of what it carries, w gravity across
its axis. What h can be is a set, and the most that w . h can be is a function of w alone: the set's support function,
which is convex, and grows with the length of w. Every joint on the way is a maximum over its turns, which leaves it so.
Of such a function (Rockafellar 1970, section 13) `f(x) <= sum c_k f(x_k)` where `x = sum c_k x_k` with no c_k negative:
between the directions of a lattice its values there bound it, within the square of their distance.
"""

from __future__ import annotations

from functools import cache, cached_property
from math import ceil, cos, floor, pi, sin, tan
from typing import Any, NamedTuple

import numpy as np

from robodyn.support.floats import Floats


class Mix(NamedTuple):
    """(4, N) places in a lattice and the shares, none negative, of their directions that add up to N vectors."""

    places: Any
    shares: Floats


class Lattice:
    """Directions by polar angle (rows + 1 of them, the poles as well) and longitude (columns, a multiple of 4) about z.

    Values are (..., rows + 1, columns): of functions that are convex, and twice as large for vectors twice as long.
    """

    def __init__(self, rows: int, columns: int) -> None:
        """Args: rows: even; columns: a multiple of 4."""
        self.rows, self.columns = rows, columns
        self.polar, self.step = pi / rows, 2.0 * pi / columns
        self.bulge = 1.0 / cos(self.step / 2.0) - 1.0  # of an arc over its chord, at most

    @cached_property
    def directions(self) -> Floats:
        """(3, (rows + 1) columns) unit vectors."""
        theta = self.polar * np.arange(self.rows + 1)[:, None]
        phi = self.step * np.arange(self.columns)
        x, y, z = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0.0 * phi
        return np.array([x.ravel(), y.ravel(), z.ravel()])

    @property
    def size(self) -> int:
        return (self.rows + 1) * self.columns

    @cached_property
    def sine(self) -> Floats:
        return np.asarray(np.sin(self.polar * np.arange(self.rows + 1))[:, None])

    def mix(self, w: Floats) -> Mix:
        """Return the corners of the cells, planar trapezoids, through which vectors w (3, N) point, with their shares
        of them."""
        x, y, z = w
        phi = np.arctan2(y, x) % (2.0 * pi)
        column = np.minimum((phi / self.step).astype(np.int64), self.columns - 1)
        aside = phi - (column + 0.5) * self.step
        along = np.hypot(x, y) * np.cos(aside) / cos(self.step / 2.0)
        size, theta = np.hypot(along, z), np.arctan2(along, z)
        row = np.clip((theta / self.polar).astype(np.int64), 0, self.rows - 1)
        theta = theta - row * self.polar
        upper, lower = (size * np.sin(part) / sin(self.polar) for part in (self.polar - theta, theta))
        right = 0.5 + 0.5 * np.tan(aside) / tan(self.step / 2.0)
        first, second = row * self.columns + column, row * self.columns + (column + 1) % self.columns
        places = np.array([first, second, first + self.columns, second + self.columns])
        return Mix(places, np.array([upper * (1.0 - right), upper * right, lower * (1.0 - right), lower * right]))

    def at(self, values: Floats, mix: Mix) -> Floats:
        """Return (..., N) bounds from above of functions of vectors, given as their `mix`."""
        flat = values.reshape(*values.shape[:-2], -1)
        found = flat[..., mix.places[0]] * mix.shares[0]
        for place, share in zip(mix.places[1:], mix.shares[1:], strict=True):
            found += flat[..., place] * share
        return np.asarray(found)

    def opposite(self, values: Floats) -> Floats:
        """Return the functions of the opposite directions."""
        return np.asarray(np.roll(values[..., ::-1, :], self.columns // 2, axis=-1))

    def turned(self, values: Floats, low: float, high: float) -> Floats:
        """Return bounds of the largest value over turns of the lattice about z by an angle q from low to high [rad]:
        `max_q f(Rot(z, q)^T w)`.

        An arc between two places is their mix, less a part of what stands along z, of up to `bulge`."""
        axial = np.abs(np.cos(self.polar * np.arange(self.rows + 1)))[:, None]
        behind = np.where(np.arange(self.rows + 1) < self.rows / 2, values[..., -1, :1], values[..., 0, :1])
        back = axial * behind[..., None]

        def between(q: float) -> Floats:
            k = floor(q / self.step)
            first, second = (sin(x) / sin(self.step) for x in ((k + 1) * self.step - q, q - k * self.step))
            moved = first * np.roll(values, k, axis=-1) + second * np.roll(values, k + 1, axis=-1)
            return np.asarray(moved + max(first + second - 1.0, 0.0) * back)

        if low == high:
            return between(low)
        first, last = ceil(low / self.step), floor(high / self.step)
        if last - first + 1 >= self.columns:
            most = np.broadcast_to(values.max(axis=-1, keepdims=True), values.shape)
        else:
            most = np.maximum(between(low), between(high))
            if last >= first:
                width, wide = 1, values
                while 2 * width <= last - first + 1:
                    wide, width = np.maximum(wide, np.roll(wide, width, axis=-1)), 2 * width
                wide = np.maximum(wide, np.roll(wide, last - first + 1 - width, axis=-1))
                most = np.maximum(most, np.roll(wide, first, axis=-1))
        return np.asarray(most + self.bulge * (np.maximum(most, 0.0) + np.maximum(back, 0.0)))

    def across(self, support: Floats) -> Floats:
        """Return the most that `(h x g) . z` can be, of directions g, where `support` is that of h."""
        return np.asarray(self.sine * np.roll(support[self.rows // 2], self.columns // 4))

    def tilting(self, support: Floats) -> Floats:
        """Return the most that the part of `h x g` across z can be in length: `max |h_z g_xy - g_z h_xy|`, by the
        directions of the lattice's longitudes, between which a circle stands out of a polygon."""
        g_z, g_xy = np.cos(self.polar * np.arange(self.rows + 1)), self.sine[:, 0]
        most, count, upwards = np.zeros(support.shape), min(self.columns, 64), g_z > 0.0
        for k in range(0, self.columns, self.columns // count):
            x, z = np.abs(g_z), g_xy * cos(k * self.step)
            theta, size = np.arctan2(x, z), np.hypot(x, z)
            row = np.clip((theta / self.polar).astype(np.int64), 0, self.rows - 1)
            theta = theta - row * self.polar
            upper, lower = (size * np.sin(part) / sin(self.polar) for part in (self.polar - theta, theta))
            found = upper[:, None] * support[row] + lower[:, None] * support[row + 1]
            found[upwards] = np.roll(found[upwards], self.columns // 2, axis=1)
            np.maximum(most, np.roll(found, -k, axis=1), out=most)
        return most / cos(pi / len(range(0, self.columns, self.columns // count)))


@cache
def lattice(rows: int) -> Lattice:
    """Return the lattice of so many rows, and twice as many columns."""
    return Lattice(rows, 2 * rows)
