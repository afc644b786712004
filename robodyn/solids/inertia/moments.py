"""Mass, first moment and inertia matrix about one origin: the form in which bodies fixed together simply add up."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from robodyn.programs.vectors import IDENTITY, ZERO, Array, Scalar, product, skew


class Inertia(NamedTuple):
    """The mass of a body and its moments about the origin of its axes, in these axes.

    Attributes:
        m: mass [kg].
        mc: first moment, mass times centre of mass [kg m].
        I: inertia matrix about the origin [kg m^2].
    """

    m: Scalar
    mc: Array
    I: Array

    @property
    def centre_of_mass(self) -> Array:
        """c = mc / m [m]; the origin where there is no mass."""
        return self.mc / self.m if self.m else ZERO


MASSLESS = Inertia(0.0, ZERO, np.zeros((3, 3)))


def inertia_of(m: float, c: Array, I_c: Array, R: Array = IDENTITY, p: Array = ZERO) -> Inertia:
    """The moments of a body whose frame stands at rotation R and origin p, about the origin of the outer frame.

    With c' = R c + p: `m`, `m c'`, `R I_c R^T - m [c'][c']`, the inertia rotation law and the parallel axis theorem.
    Nothing is asked of m and I_c, so that unphysical inertias pass through unchanged.

    Args:
        m: kg.
        c: (3,) centre of mass in the body's frame [m].
        I_c: (3, 3) inertia matrix about the centre of mass, in the body's axes [kg m^2].

    Accuracy: each entry within 16 eps of the sum of the magnitudes that add up to it.
    """
    centre, turned = product(R, c) + p, product(R, I_c, R.T)
    return Inertia(m, m * centre, turned - m * product(skew(centre), skew(centre)))


def combined(bodies: Iterable[Inertia]) -> Inertia:
    """The moments of several bodies fixed to each other, all given in the same frame: their sums."""
    m, mc, I = MASSLESS
    for body in bodies:
        m, mc, I = m + body.m, mc + body.mc, I + body.I
    return Inertia(m, mc, I)
