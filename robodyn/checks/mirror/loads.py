"""Masses and moments of mirror twins side by side."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robodyn.checks.bodies.masses import POINT, principal_moments
from robodyn.checks.context import Context, Thresholds
from robodyn.checks.mirror.pairs import Pair, link_inertia, pairs, reflected
from robodyn.programs.linear import eigen
from robodyn.programs.vectors import length
from robodyn.robot.urdf.parts import Inertial
from robodyn.robot.urdf.view import InertialView, LinkView
from robodyn.support.floats import Floats
from robodyn.support.wording import shown

MASS = 0.02
"""How far the masses of twins may differ."""
MOMENTS = 0.10
"""How far their moments may differ, each divided by its mass, relative to the largest."""
ONE_OF_TWO = "correct the one of the two that is wrong, or allow it where the parts differ"
_FLOOR = 1e-3
"""A shift of the centre of mass that is no more is none [m]."""


@dataclass(frozen=True, eq=False)
class Twins:
    """A pair of which both links have mass.

    Attributes:
        link, inertial: the right link in the file.
        masses: of the left and the right link [kg].
        c, I: centre of mass [m] and inertia by mass [m^2] of the left link's mirror image, in the right link's axes;
            see `reflected`.
        c_right, I_right: those of the right link.
        limits: thresholds of the check.
    """

    pair: Pair
    link: LinkView
    inertial: InertialView
    masses: tuple[float, float]
    c: Floats
    I: Floats
    c_right: Floats
    I_right: Floats
    limits: Thresholds

    @property
    def other(self) -> str:
        """The left link, as messages name it."""
        return f"{shown(self.pair.left.name)} (line {self.pair.left.line})"

    @property
    def mass_differs(self) -> bool:
        return abs(self.masses[0] - self.masses[1]) > MASS * max(self.masses)

    @property
    def moments(self) -> tuple[Floats, Floats]:
        """(3,) principal moments by mass of the left and the right link, ascending [m^2]."""
        return _ascending(self.I), _ascending(self.I_right)

    @property
    def real(self) -> bool:
        """Whether bodies can have both of the tensors; where they cannot, other rules say so."""
        both = self.pair.left.inertial, self.pair.right.inertial
        return all(one is not None and _is_real(one, self.limits) for one in both)

    @cached_property
    def moments_apart(self) -> float:
        """By mass or as they stand, so that a wrong mass alone sets no moments apart; at most three times what the
        tensors are, so that they are not computed where that is no more than they may be."""
        bound = 3.0 * self.tensors_apart
        return bound if bound <= MOMENTS else self._apart(*self.moments)

    @cached_property
    def tensors_apart(self) -> float:
        return self._apart(self.I, self.I_right)

    def _apart(self, left: Floats, right: Floats) -> float:
        mass, mass_right = self.masses
        return min(_apart(left, right), _apart(mass * left, mass_right * right))

    @property
    def shift(self) -> float:
        """How far the centre of mass is from its mirror image [m]."""
        return length(self.c_right - self.c)

    @property
    def centre_is_copied(self) -> bool:
        """Whether the centre of mass is not where it ought to be, but where the left link's is in its own axes."""
        left = self.pair.left.inertial
        copy = np.zeros(3) if left is None else link_inertia(left)[0]
        return self.shift > self.most_shift and length(self.c_right - copy) <= self.most_shift

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
        limits = context.thresholds
        yield Twins(pair, link, link.inertial, masses, c, I / left.mass, c_right, I_right / right.mass, limits)


def _is_real(inertial: Inertial, limits: Thresholds) -> bool:
    """Return whether a body of more than a point's size can have the tensor, as RD204, RD206 and RD207 have it."""
    small, middle, large = principal_moments(inertial.inertia)
    real = small > limits.positive_definite * large and small + middle >= (1 - limits.triangle) * large
    return real and large > POINT * POINT * inertial.mass


def _ascending(I: Floats) -> Floats:
    return eigen(I)[0][::-1]


def _apart(one: Floats, other: Floats) -> float:
    largest = max(np.abs(one).max(), np.abs(other).max())
    return float(np.abs(one - other).max() / largest) if largest else 0.0
