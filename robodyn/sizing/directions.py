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

    Values are (..., size), by rows: of functions that are convex, and twice as large for vectors twice as long.
    """

    def __init__(self, rows: int, columns: int) -> None:
        """Args: rows: even; columns: a multiple of 4."""
        self.rows, self.columns = rows, columns
        self.polar, self.step = pi / rows, 2.0 * pi / columns
        self.bulge = 1.0 / cos(self.step / 2.0) - 1.0  # of an arc over its chord, at most

    @cached_property
    def directions(self) -> Floats:
        """(3, size) unit vectors."""
        theta = self.polar * np.arange(self.rows + 1)[:, None]
        phi = self.step * np.arange(self.columns)
        x, y, z = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0.0 * phi
        return np.array([x.ravel(), y.ravel(), z.ravel()])

    @property
    def size(self) -> int:
        return (self.rows + 1) * self.columns

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
        return np.asarray(sum(values[..., k] * share for k, share in zip(mix.places, mix.shares, strict=True)))

    def turned(self, values: Floats, low: float, high: float) -> Floats:
        """Return bounds of the largest value over turns of the lattice about z by an angle q from low to high [rad]:
        `max_q f(Rot(z, q)^T w)`.

        An arc between two places is their mix, less a part of what stands along z, of up to `bulge`."""
        given, values = values.shape, values.reshape(*values.shape[:-1], -1, self.columns)
        height = np.cos(self.polar * np.arange(self.rows + 1))
        behind = np.where(height > 0.0, values[..., -1, :1], values[..., 0, :1])
        back = np.abs(height)[:, None] * behind[..., None]

        def between(q: float) -> Floats:
            k = floor(q / self.step)
            first, second = (sin(x) / sin(self.step) for x in ((k + 1) * self.step - q, q - k * self.step))
            moved = first * np.roll(values, k, axis=-1) + second * np.roll(values, k + 1, axis=-1)
            return np.asarray(moved + max(first + second - 1.0, 0.0) * back)

        if low == high:
            return between(low).reshape(given)
        most, first = np.maximum(between(low), between(high)), ceil(low / self.step)
        count, width, wide = min(floor(high / self.step) - first + 1, self.columns), 1, values
        if count > 0:
            while 2 * width <= count:
                wide, width = np.maximum(wide, np.roll(wide, width, axis=-1)), 2 * width
            wide = np.maximum(wide, np.roll(wide, count - width, axis=-1))
            most = np.maximum(most, np.roll(wide, first, axis=-1))
        return np.asarray(most + self.bulge * (np.maximum(most, 0.0) + np.maximum(back, 0.0))).reshape(given)

    def about(self, support: Floats, side: float = 1.0) -> Floats:
        """Return the most that `(h x g) . z`, times the side, can be of directions g, `support` being that of h."""
        return self.at(support, self.mix(np.cross(self.directions, (0.0, 0.0, side), axisa=0).T))

    def tilting(self, support: Floats) -> Floats:
        """Return the most that the part of `h x g` across z can be in length, by directions around z, between which a
        circle stands out of a polygon."""
        most, places = np.zeros(support.shape), range(0, self.columns, max(self.columns // 64, 1))
        for k in places:
            turned = np.roll(support.reshape(-1, self.columns), -k, axis=1).ravel()
            along = self.at(turned, self._about_x).reshape(-1, self.columns)
            most = np.maximum(most, np.roll(along, k, axis=1).ravel())
        return most / cos(pi / len(places))

    @cached_property
    def _about_x(self) -> Mix:
        return self.mix(np.cross(self.directions, (1.0, 0.0, 0.0), axisa=0).T)


@cache
def lattice(rows: int) -> Lattice:
    """Return the lattice of so many rows, and twice as many columns."""
    return Lattice(rows, 2 * rows)
