"""Closed forms of uniform solids. The frame of each stands at the centre of its bounding box, its axis along z.

Each takes its lengths [m], none negative, and either `density` [kg/m^3] or `mass` [kg]; zero lengths, as of a plate,
where the mass is given. Second moments, sums of positive terms, keep their digits however flat or slender the solid is.
They are the moments of inertia of Beer, Johnston, "Vector Mechanics for Engineers": S_xx = (I_yy + I_zz - I_xx) / 2.

Raises:
    InputError: a length is negative or not finite, density and mass are both given or both missing, or a solid without
        volume has a density.

Accuracy: volume, area, mass and each second moment within 8 eps.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import isfinite, pi

import numpy as np

from robodyn.errors import InputError
from robodyn.programs.vectors import ZERO
from robodyn.solids.inertia.properties import MassProperties

WATER = 1000.0
"""Density [kg/m^3] that is assumed where neither a density nor a mass is given."""


def box(x: float, y: float, z: float, *, density: float | None = None, mass: float | None = None) -> MassProperties:
    """S_c = m diag(x^2, y^2, z^2) / 12, V = x y z, for edges x, y, z."""
    area = 2 * (x * y + y * z + z * x)
    return _solid("box", (x, y, z), x * y * z, area, (x * x / 12, y * y / 12, z * z / 12), density, mass)


def sphere(radius: float, *, density: float | None = None, mass: float | None = None) -> MassProperties:
    """S_c = m r^2 / 5 on the diagonal, V = 4 pi r^3 / 3."""
    square = radius * radius
    return _solid("sphere", (radius,), 4 * pi / 3 * square * radius, 4 * pi * square, (square / 5,) * 3, density, mass)


def cylinder(
    radius: float, length: float, *, density: float | None = None, mass: float | None = None
) -> MassProperties:
    """S_c = m diag(r^2 / 4, r^2 / 4, L^2 / 12), V = pi r^2 L, as URDF's <cylinder>."""
    across, lengths = radius * radius / 4, (radius, length)
    area = 2 * pi * radius * (radius + length)
    moments = across, across, length * length / 12
    return _solid("cylinder", lengths, pi * radius**2 * length, area, moments, density, mass)


def capsule(radius: float, length: float, *, density: float | None = None, mass: float | None = None) -> MassProperties:
    """Return a cylinder of this length between two half balls, V = pi r^2 (L + 4 r / 3).

    With the parts w = L / (L + 4 r / 3) of the mass in the cylinder and b = 1 - w in the balls: across
    S = m (w / 4 + b / 5) r^2, along the axis S = m (w L^2 / 12 + b (r^2 / 5 + 3 r L / 8 + L^2 / 4)). The length is that
    of the cylinder alone, as in SDFormat.
    """
    whole = length + 4 * radius / 3
    straight, round = (length / whole, 4 * radius / 3 / whole) if whole else (0.0, 1.0)
    across = (straight / 4 + round / 5) * radius * radius
    ends = radius * radius / 5 + 3 * radius * length / 8 + length * length / 4
    along = straight * length * length / 12 + round * ends
    area = 2 * pi * radius * (length + 2 * radius)
    moments = across, across, along
    return _solid("capsule", (radius, length), pi * radius**2 * whole, area, moments, density, mass)


def _solid(
    name: str,
    lengths: tuple[float, ...],
    volume: float,
    area: float,
    per_mass: tuple[float, float, float],
    density: float | None,
    mass: float | None,
) -> MassProperties:
    for length in lengths:
        if not (isfinite(length) and length >= 0):
            raise InputError(f"a {name} cannot have the length {length:g} m", remedy="give finite, positive metres")
    if (density is None) == (mass is None):
        raise InputError(f"a {name} needs either a density or a mass")
    if mass is None:
        if not volume:
            raise InputError(f"a {name} without volume has no mass by its density", remedy="give its mass")
        assert density is not None
        mass = density * volume
    return MassProperties(mass, ZERO, mass * np.diag(per_mass), volume, area)


SHAPES: Mapping[str, Callable[..., MassProperties]] = {
    "box": box,
    "cylinder": cylinder,
    "sphere": sphere,
    "capsule": capsule,
}
"""Closed forms by the shapes of URDF."""
