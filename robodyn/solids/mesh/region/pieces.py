"""Columns cut into pieces, integrals over them, and what a closed surface counts too often."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robodyn.programs.vectors import length, product
from robodyn.solids.mesh.indexed import Mask
from robodyn.solids.mesh.region.columns import Hits, Integers, Lattice, in_order
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
        lattice = Lattice.over(corners, direction, count=count)
        every, _ = pieces(lattice.hits(corners))
        wrong = every.of((every.weight != 0) & (every.weight != 1))
        found.append(wrong._replace(weight=wrong.weight - (wrong.weight > 0)).moments(lattice))
    return np.array(found)
