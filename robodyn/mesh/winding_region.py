"""Where the winding number of an open surface is above a level, along columns."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robodyn.mesh.columns import Hits, Lattice
from robodyn.mesh.indexed import Indexed, Mask
from robodyn.mesh.pieces import Pieces, joined, pieces
from robodyn.mesh.triangles import Floats
from robodyn.mesh.winding import winding_numbers

_NEAR_END = 1e-6
"""Share of a piece from its end at which the winding number there is taken."""

_HALVINGS = 10


@dataclass(frozen=True, eq=False)
class Field:
    """Winding numbers of an open surface along the columns of a lattice.

    With caps the surface is closed, and its winding number a whole number that is counted; that of the caps, which are
    few, is taken off.

    Attributes:
        ends: pieces between hits of the surface or of caps, weighted with the winding number of both.
        values: (3, n) that of the surface alone at the start, in the middle and at the stop of each.
    """

    lattice: Lattice
    caps: Indexed
    ends: Pieces
    values: Floats

    @classmethod
    def along(cls, lattice: Lattice, corners: Floats, caps: Indexed) -> Field:
        """Args: corners: (m, 3, 3) of the surface with its caps."""
        ends = pieces(_with_margins(lattice.hits(corners)))
        field = cls(lattice, caps, ends, np.zeros((3, len(ends.start))))
        length = ends.stop - ends.start
        shares = (_NEAR_END, 0.5, 1 - _NEAR_END)
        values = np.stack([field._at(ends, ends.start + share * length) for share in shares])
        return replace(field, values=values)

    def above(self, level: float) -> Pieces:
        """The pieces with more than this winding number, less those with a positive one with caps."""
        middle = (self.ends.start + self.ends.stop) / 2
        depths = self.ends.start, middle, self.ends.stop
        with_caps = self.ends.of(self.ends.weight > 0)
        parts = [replace(with_caps, weight=-np.ones(len(with_caps.start)))]
        for k in (0, 1):
            half = replace(self.ends, start=depths[k], stop=depths[k + 1])
            parts += self._parts(half, self.values[k] - level, self.values[k + 1] - level, level)
        return joined(parts)

    @property
    def inside(self) -> float:
        """The volume of pieces with a winding number above 1/2 in the middle."""
        return self._volume(self.values[1] > 0.5)

    @property
    def inverted(self) -> float:
        """That of pieces with one below -1/2 there."""
        return self._volume(self.values[1] < -0.5)

    @property
    def doubtful(self) -> float:
        """That of pieces which are inverted or have one from 1/3 to 2/3 there."""
        return self.inverted + self._volume((self.values[1] > 1 / 3) & (self.values[1] < 2 / 3))

    def _volume(self, chosen: Mask) -> float:
        return self.lattice.cell * float((self.ends.stop - self.ends.start)[chosen].sum())

    def _parts(self, half: Pieces, first: Floats, last: Floats, level: float) -> list[Pieces]:
        whole = half.of((first > 0) & (last > 0))
        cut = (first > 0) != (last > 0)
        rest = half.of(cut)
        root = self._root(rest, first[cut], last[cut], level)
        leads = first[cut] > 0
        part = replace(rest, start=np.where(leads, rest.start, root), stop=np.where(leads, root, rest.stop))
        return [replace(piece, weight=np.ones(len(piece.start))) for piece in (whole, part)]

    def _root(self, within: Pieces, first: Floats, last: Floats, level: float) -> Floats:
        a, b = within.start, within.stop
        for _ in range(_HALVINGS):
            middle = (a + b) / 2
            value = self._at(within, middle) - level
            left = (value > 0) == (first > 0)
            a, first = np.where(left, middle, a), np.where(left, value, first)
            b, last = np.where(left, b, middle), np.where(left, last, value)
        root: Floats = a + (b - a) * first / (first - last)
        return root

    def _at(self, where: Pieces, depth: Floats) -> Floats:
        points = np.stack([*self.lattice.places(where.column), depth], axis=1) @ self.lattice.frame
        return where.weight - winding_numbers(points, self.caps)


def _with_margins(hits: Hits) -> Hits:
    """With a hit that changes nothing before the first and after the last of each column."""
    column = np.unique(hits.column)
    if not len(column):
        return hits
    lo, hi = hits.depth.min(), hits.depth.max()
    margin = (hi - lo) / 8
    ends = np.repeat([lo - margin, hi + margin], len(column))
    nothing = np.zeros(2 * len(column), hits.sign.dtype)
    return Hits(
        np.concatenate([hits.column, column, column]),
        np.concatenate([hits.depth, ends]),
        np.concatenate([hits.sign, nothing]),
    )
