"""Moments of the region where the winding number of an open surface is above 1/2, and how well they are known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robodyn.solids.mesh.indexed import Indexed
from robodyn.solids.mesh.region.columns import Lattice
from robodyn.solids.mesh.region.winding_region import COLUMNS, Field, centred, directions, excess, relative
from robodyn.solids.mesh.region.winding_tree import WindingTree
from robodyn.support.floats import Floats

_FEWEST = 128
"""Columns in each direction to begin with."""

LARGEST_BAR = 0.15
"""Above which an open surface has no definite volume: a sphere without a seventh has one, a box without a side not."""

_MOST = 4096

_COST = 5e7
"""Of the winding numbers that may be taken: each costs as many as there are caps, and `_EACH`."""

_EACH = 800

_FOR_EXCESS = 1024
"""Columns to begin with on which it is counted what the surface with caps encloses too often."""

_ENOUGH_MET = 30
"""Caps that columns meet, for what is found around them to be more than chance."""

_SHARE = 0.3
"""Of the error bar, that may be for want of columns."""

_FINE = 5e-5
"""Error for want of columns that is always small enough."""

_ORDER = 0.75
"""With which power of the number of columns the error falls, about."""

_CLEARLY = 3.0
"""Times the error for want of columns by which what is refused at once is above the largest bar."""

_BRACKET = 2.0
"""Error bar of a region over the volume between the winding numbers 1/3 and 1/2, or 1/2 and 2/3."""


@dataclass(frozen=True, eq=False)
class OpenSurface:
    """An open surface, caps that close it, their winding number, and integrals over what they enclose together.

    Attributes:
        surface, corners: (n, 3, 3) without and with caps.
        signed: (4, 4) integral of y y^T, y = (x, 1), times the winding number.
    """

    surface: Floats
    corners: Floats
    caps: Indexed
    tree: WindingTree
    signed: Floats

    @classmethod
    def of(cls, mesh: Indexed, caps: Indexed, signed: Floats) -> OpenSurface:
        """About the point that the integrals are about."""
        return cls(mesh.corners, np.concatenate([mesh.corners, caps.corners]), caps, WindingTree.of(caps), signed)


@dataclass(frozen=True, eq=False)
class Sample:
    """What some columns tell of a region.

    Attributes:
        region: (4, 4) integral of y y^T, y = (x, 1).
        bracket: (4, 4) its error, about the centre, for what is not definite in the region.
        differ: (4, 4) by how much directions differ.
        spread: (4, 4) the error for want of columns: that, and not less than what fewer columns let expect.
        count: of columns in each direction.
        met: how many caps they met. cost: of the winding numbers that were taken.
        too_often: what surface and caps enclose too often. counted: the columns that tell so.
    """

    region: Floats
    bracket: Floats
    differ: Floats
    spread: Floats
    count: int
    met: int
    cost: float
    too_often: Floats
    counted: int

    @property
    def error(self) -> Floats:
        """(4, 4)."""
        return self.bracket + self.spread

    @property
    def refused(self) -> bool:
        """Whether the volume is not definite, however many columns there are."""
        return bool(self.bracket[3, 3] - _CLEARLY * self.spread[3, 3] > LARGEST_BAR * self.region[3, 3])

    @property
    def definite(self) -> bool:
        """Whether the volume is, as far as these columns tell."""
        return bool(self.error[3, 3] <= LARGEST_BAR * self.region[3, 3])

    @property
    def growth(self) -> float:
        """How many times as many columns there should be, below 1.5 if these are enough."""
        differ, bracket = (relative(part, self.region) for part in (self.differ, self.bracket))
        wanted = (differ / max(_FINE, _SHARE * bracket)) ** (1 / _ORDER)
        if self.met < _ENOUGH_MET or not self.definite:
            wanted = max(wanted, 4)
        return float(min(wanted, _COST / max(self.cost, 1)))


def definite(surface: OpenSurface) -> Sample | None:
    """Return a sample of the region with the columns that it takes; None if its volume is not definite."""
    count, found = _FEWEST, None
    while True:
        found = sample(surface, count, found)
        if found is None or found.refused:
            return None
        more = min(int(count * found.growth), _MOST)
        if more < 1.5 * count:
            return found if found.definite else None
        count = more


def sample(surface: OpenSurface, count: int, before: Sample | None = None) -> Sample | None:
    """By about so many columns in each of three directions; None if one shows that the region is not definite.

    Args:
        before: by fewer columns.
    """
    by_level, inverted, met, cost = [], 0.0, 0, 0.0
    for direction in directions():
        lattice = Lattice.over(surface.corners, direction, count=count)
        field = Field.along(lattice, surface.surface, surface.caps, surface.tree)
        if field.doubtful > 3 * LARGEST_BAR * field.inside:
            return None
        by_level.append([field.above(level).moments(lattice) for level in (1 / 3, 1 / 2, 2 / 3)])
        inverted = max(inverted, field.inverted)
        met += field.met
        cost += 3 * field.values.shape[1] * (len(surface.caps.faces) + _EACH)
    counted = _FOR_EXCESS if before is None else before.counted
    too_often = excess(surface.corners, counted) if before is None else before.too_often
    while True:
        totals = surface.signed - too_often.mean(axis=0) + np.array(by_level)
        region = totals[:, 1].mean(axis=0)
        if region[3, 3] <= 0:
            return None
        bracket, differ = _errors(totals, region, inverted)
        of_excess = np.ptp(centred(too_often, region), axis=0)
        fine = max(_FINE, _SHARE * relative(bracket + differ, region)) / 2
        if counted >= COLUMNS or relative(of_excess, region) <= fine:
            spread = differ = differ + of_excess
            if before is not None:
                spread = np.maximum(differ, before.spread * (before.count / count) ** _ORDER)
            return Sample(region, bracket, differ, spread, count, met, cost, too_often, counted)
        counted = min(4 * counted, COLUMNS)
        too_often = excess(surface.corners, counted)


def _errors(totals: Floats, region: Floats, inverted: float) -> tuple[Floats, Floats]:
    """(4, 4) the bracket and the spread, without that of the excess."""
    about = centred(totals, region)
    wide, middle, narrow = about.mean(axis=0)
    bracket = _BRACKET * np.maximum(np.abs(wide - middle), np.abs(middle - narrow))
    bracket[3, 3] += inverted
    return bracket, np.ptp(about[:, 1], axis=0)
