"""Solids with smooth faces, their exact moments and their tessellations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import pi

import numpy as np

from helpers import mesh_samples as samples
from helpers.plane_curves import (
    Loop,
    arc,
    bracket,
    corners_of,
    hole,
    lever,
    line,
    polygon,
    pulley_top,
    quadrature,
    ring,
    rounded_disc,
)
from helpers.tessellations import icosphere, prism, rounded_corners, turned_profile


@dataclass(frozen=True, eq=False)
class Solid:
    """Exact volume, centre and second moments about it; `mesh` takes the number of facets of a full turn."""

    name: str
    volume: float
    com: np.ndarray
    S: np.ndarray
    mesh: Callable[[int], np.ndarray]


def revolved(name: str, profile: Loop) -> Solid:
    """About z: the profile (r, z) goes upwards along the outside, from the axis to the axis or around."""
    x, y, dy = quadrature(profile)
    V, first, along = (pi * (x**2 * y**k) @ dy for k in range(3))
    across = pi / 4 * x**4 @ dy
    z = first / V
    return Solid(name, V, np.array((0, 0, z)), np.diag((across, across, along - z * first)), turned_profile(profile))


def extruded(name: str, outline: Loop, holes: list[Loop], height: float) -> Solid:
    """Along z, centred there: the outline goes counter-clockwise, the holes clockwise."""
    x, y, dy = (np.concatenate(part) for part in zip(*map(quadrature, (outline, *holes)), strict=True))
    area, cx, cy = x @ dy, x**2 / 2 @ dy, (x * y) @ dy
    xx, xy, yy = x**3 / 3 @ dy, (x**2 * y / 2) @ dy, (x * y**2) @ dy
    c = np.array((cx / area, cy / area, 0.0))
    S = height * np.array([(xx, xy, 0), (xy, yy, 0), (0, 0, area * height**2 / 12)])
    V = height * area
    return Solid(
        name, V, c, S - V * np.outer(c, c), lambda n: prism([corners_of(loop, n) for loop in (outline, *holes)], height)
    )


def rounded_box(name: str, sizes: tuple[float, float, float], r: float) -> Solid:
    """A box of these sizes with edges and corners of radius r: all points within r of a smaller box."""
    inner = np.asarray(sizes) - 2 * r
    V, seconds = 0.0, []
    u, w = np.polynomial.legendre.leggauss(40)
    angle, w = (u + 1) * pi / 4, w * pi / 4
    for i in range(3):
        b, c = np.delete(inner, i)
        rho, x = r * np.cos(angle), inner[i] / 2 + r * np.sin(angle)
        cap = (b * c + 2 * (b + c) * rho + pi * rho**2) * rho * w
        section = b * c + 2 * (b + c) * r + pi * r**2
        V = section * inner[i] + 2 * cap.sum()
        seconds.append(section * inner[i] ** 3 / 12 + 2 * cap @ x**2)
    return Solid(name, V, np.zeros(3), np.diag(seconds), lambda n: rounded_corners(inner / 2, r, n))


def ellipsoid(name: str, semi_axes: tuple[float, float, float], unit_ball: Callable[[int], np.ndarray]) -> Solid:
    a = np.asarray(semi_axes)
    V = 4 / 3 * pi * a.prod()
    return Solid(name, V, np.zeros(3), V / 5 * np.diag(a**2), lambda n: unit_ball(n) * a)


@cache
def solids() -> tuple[Solid, ...]:
    """Round, filleted and drilled parts."""
    r = 0.25
    return (
        revolved("cylinder", [line((0, -1), (1, -1)), line((1, -1), (1, 1)), line((1, 1), (0, 1))]),
        revolved("tube", ring([(0.7, -1), (1, -1), (1, 1), (0.7, 1)])),
        revolved("cone", [line((0, 0), (1, 0)), line((1, 0), (0, 2))]),
        revolved("capsule", [arc((0, -1), 0.5, -90, 0), line((0.5, -1), (0.5, 1)), arc((0, 1), 0.5, 0, 90)]),
        revolved("half ball", [line((0, 0), (1, 0)), arc((0, 0), 1, 0, 90)]),
        revolved("ball", [arc((0, 0), 1, -90, 90)]),
        revolved("rounded disc", rounded_disc(2.0, 1.0, r)),
        revolved("pulley", [*ring([(0.5, -1), (2, -1), (2, -0.8)], False), arc((2, 0), 0.8, -90, -270), *pulley_top()]),
        revolved("torus", [arc((2, 0), 0.5, -180, 180)]),
        ellipsoid("ellipsoid", (3, 2, 1), lambda n: samples.uv_sphere(1.0, max(n // 2, 4), n)),
        ellipsoid("ball of equal triangles", (1, 1, 1), icosphere),
        extruded("plate with a hole", polygon([(-2, -1), (2, -1), (2, 1), (-2, 1)]), [hole((0.7, 0.2), 0.5)], 0.4),
        extruded("bracket", bracket(), [hole((0.5, 2.3), 0.25), hole((2.3, 0.5), 0.25)], 0.6),
        extruded("lever", lever(), [hole((0, 0), 0.5), hole((4, 0), 0.2)], 0.5),
        rounded_box("rounded box", (2.0, 1.5, 1.0), r),
        rounded_box("box with small fillets", (2.0, 1.5, 1.0), 0.05),
    )
