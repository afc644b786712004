"""Masses and moments of mirror twins side by side."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from robodyn.checks.context import Context
from robodyn.checks.mirror.pairs import Pair, link_inertia, pairs, reflected
from robodyn.programs.linear import eigen
from robodyn.programs.vectors import length
from robodyn.robot.urdf.view import InertialView, LinkView
from robodyn.support.floats import Floats

MASS = 0.02
"""How far the masses of twins may differ."""
MOMENTS = 0.10
"""How far their moments may differ, each divided by its mass, relative to the largest."""
_FLOOR = 1e-3
"""A shift of the centre of mass that is no more is none [m]."""


@dataclass(frozen=True, eq=False)
class Twins:
    """A pair of which both links have mass.

    Attributes:
        link, inertial: the right link in the file.
        masses: of the left and the right link [kg].
        c, I: centre of mass [m] and inertia by mass [m^2] of the left link's mirror image, in the right link's axes.
        c_right, I_right: those of the right link.
    """

    pair: Pair
    link: LinkView
    inertial: InertialView
    masses: tuple[float, float]
    c: Floats
    I: Floats
    c_right: Floats
    I_right: Floats

    @property
    def other(self) -> str:
        return self.pair.left.name

    @property
    def mass_differs(self) -> bool:
        return abs(self.masses[0] - self.masses[1]) > MASS * max(self.masses)

    @property
    def moments(self) -> tuple[Floats, Floats]:
        """(3,) principal moments by mass of the left and the right link, ascending [m^2]."""
        return _ascending(self.I), _ascending(self.I_right)

    @property
    def moments_apart(self) -> float:
        left, right = self.moments
        return _apart(left, right)

    @property
    def tensors_apart(self) -> float:
        return _apart(self.I, self.I_right)

    @property
    def shift(self) -> float:
        """How far the centre of mass is from its mirror image [m]."""
        return length(self.c_right - self.c)

    @property
    def most_shift(self) -> float:
        """A tenth of the radius of gyration, and 1 mm at least [m]."""
        return MOMENTS * float(np.sqrt(max(np.trace(self.I_right), np.trace(self.I), 0.0) / 2.0)) + _FLOOR


def twins(context: Context) -> tuple[Twins, ...]:
    """Return the pairs of which both links have mass. From stage MODEL on."""
    return tuple(_twins(context))


def _twins(context: Context) -> Iterator[Twins]:
    for pair in context.once(pairs):
        left, right = pair.left.inertial, pair.right.inertial
        link = context.view.link[pair.right.name]
        if left is None or right is None or link.inertial is None or not (left.mass > 0 and right.mass > 0):
            continue
        (c, I), (c_right, I_right) = reflected(pair, left), link_inertia(right)
        masses = left.mass, right.mass
        yield Twins(pair, link, link.inertial, masses, c, I / left.mass, c_right, I_right / right.mass)


def _ascending(I: Floats) -> Floats:
    return eigen(I)[0][::-1]


def _apart(one: Floats, other: Floats) -> float:
    largest = max(np.abs(one).max(), np.abs(other).max())
    return float(np.abs(one - other).max() / largest) if largest else 0.0
