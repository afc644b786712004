"""Closed forms of uniform solids. The frame of each stands at the centre of its bounding box, its axis along z.

Each takes its lengths [m], none negative, and either `density` [kg/m^3] or `mass` [kg]. A length may be zero where the
mass is given: a plate, a rod, a point.

The second moments are the textbook's moments of inertia (Beer, Johnston, "Vector Mechanics for Engineers", the table of
mass moments of inertia) taken apart: S_xx = (I_yy + I_zz - I_xx) / 2. Sums of positive terms, they keep their digits
however flat or slender the solid is.

Raises:
    InputError: a length is negative or not finite, density and mass are both given or both missing, or a solid without
        volume has a density.

Accuracy: volume, area, mass and each second moment within 8 eps.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import hypot, isfinite, pi

import numpy as np

from robodyn.errors import InputError
from robodyn.programs.vectors import ZERO, Array
from robodyn.solids.inertia.properties import MassProperties

WATER = 1000.0
"""Density [kg/m^3] that is assumed where neither a density nor a mass is given."""


def box(x: float, y: float, z: float, *, density: float | None = None, mass: float | None = None) -> MassProperties:
    """S_c = m diag(x^2, y^2, z^2) / 12, V = x y z, for edges x, y, z."""
    _check_lengths("box", x, y, z)
    area = 2 * (x * y + y * z + z * x)
    return _solid("box", x * y * z, area, (x * x / 12, y * y / 12, z * z / 12), density, mass)


def sphere(radius: float, *, density: float | None = None, mass: float | None = None) -> MassProperties:
    """S_c = m r^2 / 5 on the diagonal, V = 4 pi r^3 / 3."""
    _check_lengths("sphere", radius)
    square = radius * radius
    return _solid("sphere", 4 * pi / 3 * square * radius, 4 * pi * square, (square / 5,) * 3, density, mass)


def ellipsoid(
    a: float, b: float, c: float, *, density: float | None = None, mass: float | None = None
) -> MassProperties:
    """S_c = m diag(a^2, b^2, c^2) / 5, V = 4 pi a b c / 3, for semi-axes a, b, c along x, y, z.

    The surface is 4 pi R_G(a^2 b^2, a^2 c^2, b^2 c^2) with Carlson's elliptic integral R_G (DLMF 19.33.1).
    """
    from scipy.special import elliprg

    _check_lengths("ellipsoid", a, b, c)
    area = 4 * pi * float(elliprg((a * b) ** 2, (a * c) ** 2, (b * c) ** 2))
    return _solid("ellipsoid", 4 * pi / 3 * a * b * c, area, (a * a / 5, b * b / 5, c * c / 5), density, mass)


def cylinder(
    radius: float, length: float, *, density: float | None = None, mass: float | None = None
) -> MassProperties:
    """S_c = m diag(r^2 / 4, r^2 / 4, L^2 / 12), V = pi r^2 L, as URDF's <cylinder>."""
    _check_lengths("cylinder", radius, length)
    across = radius * radius / 4
    area = 2 * pi * radius * (radius + length)
    return _solid("cylinder", pi * radius**2 * length, area, (across, across, length * length / 12), density, mass)


def capsule(radius: float, length: float, *, density: float | None = None, mass: float | None = None) -> MassProperties:
    """Return a cylinder of this length between two half balls, V = pi r^2 (L + 4 r / 3).

    With the parts w = L / (L + 4 r / 3) of the mass in the cylinder and b = 1 - w in the balls: across
    S = m (w / 4 + b / 5) r^2, along the axis S = m (w L^2 / 12 + b (r^2 / 5 + 3 r L / 8 + L^2 / 4)). The length is that
    of the cylinder alone, as in SDFormat.
    """
    _check_lengths("capsule", radius, length)
    whole = length + 4 * radius / 3
    straight, round = (length / whole, 4 * radius / 3 / whole) if whole else (0.0, 1.0)
    across = (straight / 4 + round / 5) * radius * radius
    ends = radius * radius / 5 + 3 * radius * length / 8 + length * length / 4
    along = straight * length * length / 12 + round * ends
    area = 2 * pi * radius * (length + 2 * radius)
    return _solid("capsule", pi * radius**2 * whole, area, (across, across, along), density, mass)


def cone(radius: float, length: float, *, density: float | None = None, mass: float | None = None) -> MassProperties:
    """S_c = m diag(3 r^2 / 20, 3 r^2 / 20, 3 L^2 / 80) about c = (0, 0, -L / 4), V = pi r^2 L / 3.

    The base lies at z = -L / 2, the apex at z = L / 2, as in SDFormat, FCL and USD.
    """
    _check_lengths("cone", radius, length)
    across = 3 * radius * radius / 20
    moments = (across, across, 3 * length * length / 80)
    area = pi * radius * (radius + hypot(radius, length))
    centre = np.array((0.0, 0.0, -length / 4))
    return _solid("cone", pi * radius**2 * length / 3, area, moments, density, mass, centre)


def torus(major: float, minor: float, *, density: float | None = None, mass: float | None = None) -> MassProperties:
    """S_c = m diag(R^2 / 2 + 3 r^2 / 8, R^2 / 2 + 3 r^2 / 8, r^2 / 4), V = 2 pi^2 R r^2.

    A disc of radius r (minor) carried about z at the distance R >= r (major) of its centre.
    """
    _check_lengths("torus", major, minor)
    if minor > major:
        raise InputError(f"a torus with the tube radius {minor:g} m > {major:g} m overlaps itself")
    square = minor * minor
    across = major * major / 2 + 3 * square / 8
    area = 4 * pi**2 * major * minor
    return _solid("torus", 2 * pi**2 * major * square, area, (across, across, square / 4), density, mass)


def _check_lengths(solid: str, *lengths: float) -> None:
    for length in lengths:
        if not (isfinite(length) and length >= 0):
            raise InputError(f"a {solid} cannot have the length {length:g} m", remedy="give finite, positive metres")


def _solid(
    name: str,
    volume: float,
    area: float,
    per_mass: tuple[float, float, float],
    density: float | None,
    mass: float | None,
    com: Array = ZERO,
) -> MassProperties:
    if (density is None) == (mass is None):
        raise InputError(f"a {name} needs either a density or a mass")
    if mass is None:
        if not volume:
            raise InputError(f"a {name} without volume has no mass by its density", remedy="give its mass")
        assert density is not None
        mass = density * volume
    return MassProperties(mass, com, mass * np.diag(per_mass), volume, area)


SHAPES: Mapping[str, Callable[..., MassProperties]] = {
    "box": box,
    "cylinder": cylinder,
    "sphere": sphere,
    "capsule": capsule,
}
"""Closed forms by the shapes of URDF."""
