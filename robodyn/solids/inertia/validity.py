"""Whether any body can have given mass properties, with the margin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from robodyn.programs.linear import eigen
from robodyn.programs.vectors import Array
from robodyn.solids.inertia.exact import Floats
from robodyn.solids.inertia.laws import principal_moments, second_moments
from robodyn.support.floats import HALF_UP

if TYPE_CHECKING:
    from robodyn.solids.inertia.properties import MassProperties

PRINTED = 1e-6
"""Slack for numbers rounded in print, relative to the largest principal moment."""


@dataclass(frozen=True, eq=False)
class Validity:
    """What a physical body needs, in numbers.

    Attributes:
        mass: kg.
        moments: (3,) principal moments about the centre of mass, ascending [kg m^2].
        slack: (I_1 + I_2 - I_3) / max |I_i|, twice the smallest second moment: 1 for a ball, 0 for a plate and a
            needle, negative where the triangle inequality is broken; 0 where there is no inertia.
        faults: why no body can have these properties; empty if one can.
    """

    mass: float
    moments: Floats
    slack: float
    faults: tuple[str, ...]


def validity(body: MassProperties, relative: float = PRINTED) -> Validity:
    """Return whether a body can exist: mass > 0 and no negative second moment.

    S_c positive semidefinite is the same as principal moments that are positive and obey the triangle inequality
    I_1 + I_2 >= I_3, since I_1 + I_2 - I_3 is twice the smallest second moment (Wensing, Kim, Slotine 2018).

    Args:
        relative: slack, relative to the largest principal moment.

    Accuracy: `slack` within 16 eps, or within 32 eps of itself if the second moments are positive.
    """
    principal = body.principal
    fault = _fault(principal.second, principal.moments, relative)
    faults = [] if fault is None else [fault]
    if not body.mass > 0:
        faults.insert(0, f"the mass is not positive ({body.mass:.6g} kg)")
    return Validity(body.mass, principal.moments, _slack(principal.second, principal.moments), tuple(faults))


def unphysical(I_c: Array, relative: float = PRINTED) -> str | None:
    """Return why no body can have the inertia matrix I_c about its centre of mass, or None if one can; see `validity`.

    Args:
        I_c: (3, 3) kg m^2.
        relative: slack, relative to the largest principal moment.
    """
    size = float(np.abs(I_c).max()) or 1.0
    second, _ = eigen(second_moments(I_c / size))
    return _fault(second, principal_moments(second), relative, size)


def _slack(second: Floats, moments: Floats) -> float:
    largest = np.abs(moments).max()
    return float(2 * second[2] / largest) if largest else 0.0


def _fault(second: Floats, moments: Floats, relative: float, unit: float = 1.0) -> str | None:
    """Return what is wrong with second moments and moments of inertia in units of `unit` kg m^2."""
    small, middle, large = (f"{moment * unit * HALF_UP:.6g}" for moment in moments.tolist())
    if moments[0] < -relative * moments[2]:
        return f"a principal moment of inertia is negative ({small} kg m^2)"
    if 2 * second[2] < -relative * moments[2]:
        return f"principal moments {small} + {middle} < {large} kg m^2 break the triangle inequality"
    return None
