"""Whether any body can have given mass properties, by its principal moments and by the box around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robodyn.errors import InputError
from robodyn.programs.vectors import Array, product
from robodyn.solids.inertia.laws import principal_moments, second_moments
from robodyn.support.floats import HALF_UP, Floats
from robodyn.support.linear import eigen

if TYPE_CHECKING:
    from robodyn.solids.inertia.properties import MassProperties

PRINTED = 1e-6
"""Slack for numbers rounded in print, relative to the largest principal moment."""


class Box(NamedTuple):
    """Corners (3,) [m]."""

    lo: Floats
    hi: Floats

    def placed(self, R: Array, p: Array) -> Box:
        """Return the box along the outer axes around this one, whose frame stands there at rotation R and origin p."""
        centre = product(R, (self.lo + self.hi) / 2) + p
        half = product(np.abs(R), (self.hi - self.lo) / 2)
        return Box(centre - half, centre + half)


def half_size(shape: str, size: Sequence[float]) -> Floats:
    """Return half the sizes (3,) of a box, cylinder, sphere or capsule along its own axes [m]; `size` as in URDF."""
    if shape == "box":
        return np.array(size) / 2
    radius, length = size[0], size[1] if len(size) > 1 else 0.0
    return np.array((radius, radius, length / 2 + (0.0 if shape == "cylinder" else radius)))


def around(boxes: Sequence[Box]) -> Box:
    return Box(np.min([box.lo for box in boxes], axis=0), np.max([box.hi for box in boxes], axis=0))


def counted_twice(boxes: Sequence[Box]) -> tuple[str, ...]:
    """Return a remark where bodies may overlap: boxes share more than a layer of 1e-6 of the smaller one."""
    pairs = sum(
        bool((np.minimum(a.hi, b.hi) - np.maximum(a.lo, b.lo) > 1e-6 * np.minimum(a.hi - a.lo, b.hi - b.lo)).all())
        for a, b in combinations(boxes, 2)
    )
    if not pairs:
        return ()
    which = "boxes of 1 pair of bodies overlap" if pairs == 1 else f"boxes of {pairs} pairs of bodies overlap"
    return (f"{which}: what bodies share counts twice",)


def box_bound(body: MassProperties, lo: ArrayLike, hi: ArrayLike) -> Floats:
    """(3,) spread S_ii / m over (hi_i - c_i)(c_i - lo_i): none is above 1 for a body in the box, of whatever density.

    The inequality of Bhatia and Davis (2000) for the coordinates of the mass; a uniform box reaches a third of it.
    Infinite where the centre of mass lies outside the box, or on its side and the spread is not zero. InputError where
    the mass is not positive, or lo > hi, the corners (3,) in the axes of the body's frame [m].

    Accuracy: the spread within eps, the bound within 2 eps of (hi_i - lo_i) max(|lo_i|, |hi_i|, |c_i|).
    """
    low, high = np.asarray(lo, dtype=float), np.asarray(hi, dtype=float)
    if not body.mass > 0:
        raise InputError(f"the bound of a box needs a positive mass, not {body.mass:g} kg")
    if not (low <= high).all():
        raise InputError(f"the corners of the box are in the wrong order: {low.tolist()}, {high.tolist()}")
    spread = np.diagonal(body.S_c) / body.mass
    inside = (low <= body.com) & (body.com <= high)
    bound = np.abs((high - body.com) * (body.com - low))
    ratio = np.full(3, np.inf)
    ratio[inside & (spread == 0)] = 0.0
    possible = inside & (bound > 0)
    ratio[possible] = spread[possible] / bound[possible]
    return ratio


@dataclass(frozen=True, eq=False)
class Validity:
    """What a physical body needs, in numbers.

    moments: (3,) principal moments about the centre of mass, ascending [kg m^2]; slack: (I_1 + I_2 - I_3) / max |I_i|,
    1 for a ball, 0 for a plate and a needle, negative where the triangle inequality is broken; 0 where there is no
    inertia; faults: why no body can have these properties.
    """

    mass: float
    moments: Floats
    slack: float
    faults: tuple[str, ...]


def validity(body: MassProperties, relative: float = PRINTED) -> Validity:
    """Return whether a body can exist: mass > 0 and no negative second moment.

    S_c positive semidefinite is the same as principal moments that are positive and obey the triangle inequality
    I_1 + I_2 >= I_3, since I_1 + I_2 - I_3 is twice the smallest second moment (Wensing, Kim, Slotine 2018). What is
    allowed is relative to the largest principal moment.

    Accuracy: `slack` within 16 eps, or within 32 eps of itself if the second moments are positive.
    """
    principal = body.principal
    fault = _fault(principal.second, principal.moments, relative)
    faults = [] if fault is None else [fault]
    if not body.mass > 0:
        faults.insert(0, f"the mass is not positive ({body.mass:.6g} kg)")
    largest = np.abs(principal.moments).max()
    slack = float(2 * principal.second[2] / largest) if largest else 0.0
    return Validity(body.mass, principal.moments, slack, tuple(faults))


def unphysical(I_c: Array, relative: float = PRINTED) -> str | None:
    """Return why no body can have the inertia matrix I_c (3, 3) about its centre of mass [kg m^2], None if one can."""
    size = float(np.abs(I_c).max()) or 1.0
    second, _ = eigen(second_moments(I_c / size))
    return _fault(second, principal_moments(second), relative, size)


def _fault(second: Floats, moments: Floats, relative: float, unit: float = 1.0) -> str | None:
    small, middle, large = (f"{moment * unit * HALF_UP:.6g}" for moment in moments.tolist())
    if moments[0] < -relative * moments[2]:
        return f"a principal moment of inertia is negative ({small} kg m^2)"
    if 2 * second[2] < -relative * moments[2]:
        return f"principal moments {small} + {middle} < {large} kg m^2 break the triangle inequality"
    return None
