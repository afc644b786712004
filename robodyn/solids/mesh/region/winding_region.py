"""Columns cut into pieces, integrals over them, and where the winding number of an open surface is above a level."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from robodyn.programs.vectors import length, product
from robodyn.solids.mesh.indexed import Indexed, Mask
from robodyn.solids.mesh.region.columns import Hits, Integers, Lattice, in_order
from robodyn.solids.mesh.region.winding_tree import WindingTree
from robodyn.support.floats import Floats


class Pieces(NamedTuple):
    """Parts of columns, each between two depths and with a weight."""

    column: Integers
    start: Floats
    stop: Floats
    weight: Floats

    def of(self, chosen: Mask) -> Pieces:
        """Return some of them."""
        return Pieces._make(column[chosen] for column in self)

    def moments(self, lattice: Lattice) -> Floats:
        """(4, 4) integral of y y^T times the weight, y = (x, 1); exact in depth, a sum over the columns across."""
        length = self.stop - self.start
        share = lattice.cell * self.weight * length
        Y = np.stack([*lattice.places(self.column), (self.start + self.stop) / 2, np.ones(len(length))])
        found: Floats = product(Y * share, Y.T)
        found[2, 2] += float(product(share, length**2)) / 12
        frame = np.eye(4)
        frame[:3, :3] = lattice.frame
        turned: Floats = product(frame.T, found, frame)
        return turned


def pieces(hits: Hits) -> tuple[Pieces, Integers]:
    """Return what lies between the first and the last hit of each column, weighted with its winding number.

    And the numbers of the hits at which these pieces start.
    """
    order = in_order(hits.column, hits.depth)
    column, depth = hits.column[order], hits.depth[order]
    within = column[1:] == column[:-1]
    winding = np.cumsum(hits.sign[order])[:-1][within]
    parts = Pieces(column[:-1][within], depth[:-1][within], depth[1:][within], winding.astype(np.float64))
    return parts, order[:-1][within]


def joined(parts: list[Pieces]) -> Pieces:
    """Return all of them."""
    return Pieces._make(map(np.concatenate, zip(*parts, strict=True)))


def centred(totals: Floats, region: Floats) -> Floats:
    """Integrals (..., 4, 4) of y y^T, y = (x, 1), with x from the centre of a region that has such integrals (4, 4)."""
    shift = np.eye(4)
    shift[:3, 3] = -region[:3, 3] / region[3, 3]
    about: Floats = product(shift, totals, shift.T)
    return about


def relative(error: Floats, region: Floats) -> float:
    """Return the larger of the error of the volume, of that, and of the largest of second moments, of the largest."""
    S_c = centred(region, region)[:3, :3]
    return max(float(error[3, 3] / region[3, 3]), float(error[:3, :3].max() / np.abs(S_c).max()))


COLUMNS = 16384
"""In each direction, for surfaces that are closed."""

_DIRECTIONS = np.array([(0.8203, -0.4115, 0.3971), (0.2391, 0.8770, 0.4168), (-0.5198, -0.2469, 0.8178)])
"""Nearly at right angles, and along nothing that a part has."""


def directions() -> list[Floats]:
    """Three unit vectors."""
    return [direction / length(direction) for direction in _DIRECTIONS]


def excess(corners: Floats, count: int = COLUMNS) -> Floats:
    """(3, 4, 4) in each direction, by about so many columns, the moments of what a surface counts too often."""
    found = []
    for direction in directions():
        lattice = _lattice(corners, direction, count)
        every, _ = pieces(lattice.hits(corners))
        wrong = every.of((every.weight != 0) & (every.weight != 1))
        found.append(wrong._replace(weight=wrong.weight - (wrong.weight > 0)).moments(lattice))
    return np.array(found)


_HITS = 5e5
"""Of columns with a surface, at most, about: each takes some 600 bytes."""


def _lattice(corners: Floats, direction: Floats, count: int) -> Lattice:
    """Return about so many columns, or as many as meet the triangles (m, 3, 3) not too often."""
    a, b, c = corners.transpose(1, 0, 2)
    shadows = float(np.abs(product(np.cross(b - a, c - a), direction)).sum()) / 2
    lattice = Lattice.over(corners, direction, count=count)
    most = int(count * lattice.cell * _HITS / shadows) if shadows else count
    return lattice if most >= count else Lattice.over(corners, direction, count=max(most, 1))


_NEAR_END = 1e-6
"""Share of a piece from its end at which the winding number there is taken."""

_STEPS = 4
"""In the search for where a winding number passes a level."""
_SHARP = 2.0**-16
"""Winding numbers are rounded to multiples: they are far less accurate, and the processor decides on their last digits,
as NumPy has another arctan2 with AVX-512."""


@dataclass(frozen=True, eq=False)
class Field:
    """Winding numbers of an open surface along the columns of a lattice.

    With caps the surface is closed, and its winding number a whole number that is counted; that of the caps, which are
    few, is taken off.

    Attributes:
        caps: of the surface.
        ends: pieces between hits of the surface or of caps, weighted with the winding number of both.
        values: (3, n) that of the surface alone at the start, in the middle and at the stop of each.
        met: how many hits are of caps.
    """

    lattice: Lattice
    caps: WindingTree
    ends: Pieces
    values: Floats
    met: int

    @classmethod
    def along(cls, lattice: Lattice, surface: Floats, caps: Indexed, tree: WindingTree) -> Field:
        """Args: surface: (m, 3, 3) without its caps. tree: of these."""
        found, closing = lattice.hits(surface), lattice.hits(caps.corners)
        ends, after_cap = _pieces(found, closing)
        field = cls(lattice, tree, ends, np.zeros((3, len(ends.start))), len(closing.sign))
        return replace(field, values=field._values(after_cap))

    def _values(self, after_cap: Mask) -> Floats:
        """That of caps passes from a piece to the next without a jump unless a cap is between them."""
        start, length = self.ends.start, self.ends.stop - self.ends.start
        column = self.ends.column
        new = after_cap.copy()
        new[:1] = True
        new[1:] |= (column[1:] != column[:-1]) | (
            length[:-1] <= _NEAR_END * (start.max(initial=-np.inf) - start.min(initial=np.inf))
        )
        depths = start + np.array([[_NEAR_END], [0.5], [1 - _NEAR_END]]) * length
        chosen = np.stack([new, np.ones_like(new), np.ones_like(new)])
        off = np.zeros(depths.shape)
        off[chosen] = self._of_caps(np.broadcast_to(column, depths.shape)[chosen], depths[chosen])
        off[0, 1:] = np.where(new[1:], off[0, 1:], off[2, :-1])
        values: Floats = self.ends.weight - off
        return values

    def above(self, level: float) -> Pieces:
        """Return the pieces with more than this winding number, less those with a positive one with caps."""
        middle = (self.ends.start + self.ends.stop) / 2
        halves = joined([self.ends._replace(stop=middle), self.ends._replace(start=middle)])
        first, last = self.values[:2].ravel() - level, self.values[1:].ravel() - level
        with_caps = self.ends.of(self.ends.weight > 0)
        less = with_caps._replace(weight=-np.ones(len(with_caps.start)))
        return joined([less, *self._parts(halves, first, last, level)])

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
        part = rest._replace(start=np.where(leads, rest.start, root), stop=np.where(leads, root, rest.stop))
        return [piece._replace(weight=np.ones(len(piece.start))) for piece in (whole, part)]

    def _root(self, within: Pieces, first: Floats, last: Floats, level: float) -> Floats:
        """Regula falsi, in which the value at an end that stays is halved (Illinois)."""
        a, b = within.start, within.stop
        before = np.zeros(len(a))
        for _ in range(_STEPS):
            between = a + (b - a) * (first / (first - last))
            value = within.weight - self._of_caps(within.column, between) - level
            left = (value > 0) == (first > 0)
            side = np.where(left, 1, -1)
            stays = np.where(side == before, 0.5, 1.0)
            a, b, before = np.where(left, between, a), np.where(left, b, between), side
            first, last = np.where(left, value, first * stays), np.where(left, last * stays, value)
        root: Floats = a + (b - a) * (first / (first - last))
        return root

    def _of_caps(self, column: Integers, depth: Floats) -> Floats:
        points = product(np.stack([*self.lattice.places(column), depth], axis=1), self.lattice.frame)
        return np.asarray(np.rint(self.caps.numbers(points) / _SHARP) * _SHARP)


def _pieces(surface: Hits, caps: Hits) -> tuple[Pieces, Mask]:
    """Return what lies between hits of each column, with a margin at both ends; and which pieces follow a cap."""
    hit = np.concatenate([surface.column, caps.column])
    depth = np.concatenate([surface.depth, caps.depth])
    columns = np.unique(hit)
    margins = np.empty(0)
    if len(columns):
        lo, hi = depth.min(), depth.max()
        margins = np.repeat([lo - (hi - lo) / 8, hi + (hi - lo) / 8], len(columns))
    column, depth = np.concatenate([hit, columns, columns]), np.concatenate([depth, margins])
    sign = np.concatenate([surface.sign, caps.sign, np.zeros(len(margins), caps.sign.dtype)])
    found, at = pieces(Hits(column, depth, sign))
    return found, (at >= len(surface.sign)) & (at < len(hit))
