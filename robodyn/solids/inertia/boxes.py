"""Boxes around bodies, along the axes of a frame."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from robodyn.programs.vectors import Array, product
from robodyn.solids.inertia.exact import Floats

_TOUCH = 1e-6


class Box(NamedTuple):
    """Corners (3,) [m]."""

    lo: Floats
    hi: Floats

    def placed(self, R: Array, p: Array) -> Box:
        """The box along the outer axes around this one, whose frame stands there at rotation R and origin p."""
        centre = product(R, (self.lo + self.hi) / 2) + p
        half = product(np.abs(R), (self.hi - self.lo) / 2)
        return Box(centre - half, centre + half)


def around(boxes: Sequence[Box]) -> Box:
    """The box around boxes."""
    return Box(np.min([box.lo for box in boxes], axis=0), np.max([box.hi for box in boxes], axis=0))


def overlaps(boxes: Sequence[Box]) -> int:
    """The number of pairs that share more than a layer of 1e-6 of the smaller one."""
    return sum(_overlap(a, b) for a, b in combinations(boxes, 2))


def _overlap(a: Box, b: Box) -> bool:
    shared = np.minimum(a.hi, b.hi) - np.maximum(a.lo, b.lo)
    return bool((shared > _TOUCH * np.minimum(a.hi - a.lo, b.hi - b.lo)).all())


def counted_twice(boxes: Sequence[Box]) -> tuple[str, ...]:
    """A remark where bodies may overlap, since what they share then counts twice."""
    pairs = overlaps(boxes)
    if not pairs:
        return ()
    which = "boxes of 1 pair of bodies overlap" if pairs == 1 else f"boxes of {pairs} pairs of bodies overlap"
    return (f"{which}: what bodies share counts twice",)
