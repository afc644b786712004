"""What is said about the symmetry of a body."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from robodyn.support.floats import Floats

Verdict = Literal["exact", "within tessellation", "near", "none"]

NEAR = 1e-2
"""Asymmetries above this are none, whatever the facets: coarse ones could excuse anything."""


class _Judged:
    """What has an asymmetry and a verdict."""

    asymmetry: float
    verdict: Verdict

    @property
    def holds(self) -> bool:
        return self.verdict in ("exact", "within tessellation")


@dataclass(frozen=True, eq=False)
class Plane(_Judged):
    """A candidate for a mirror plane, n . x = offset; normal (3,) of length 1, offset in units of the file."""

    normal: Floats
    offset: float
    asymmetry: float
    verdict: Verdict


@dataclass(frozen=True, eq=False)
class Axis(_Judged):
    """A candidate for an axis of symmetry; fold n for rotations by 1 / n of a turn, infinite for revolution."""

    direction: Floats
    point: Floats
    fold: float
    asymmetry: float
    verdict: Verdict


@dataclass(frozen=True)
class Product:
    """A product of inertia about the centre, in the axes of the file.

    Attributes:
        axes: "xy", "xz" or "yz".
        residual: the computed integral of x_i x_j dV, in units of the file.
        relative: the same over the root of the two second moments.
        zero: it is 0 by symmetry.
    """

    axes: str
    residual: float
    relative: float
    zero: bool


@dataclass(frozen=True, eq=False)
class Symmetry:
    """What was found, the most symmetric first, and the products xy, xz, yz.

    Attributes:
        invariants: (k, 3, 3) orthonormal basis of the second moments that the planes and axes that hold leave possible.
    """

    planes: tuple[Plane, ...]
    axes: tuple[Axis, ...]
    products: tuple[Product, ...]
    invariants: Floats

    @property
    def accepted(self) -> tuple[int, int]:
        """How many planes and axes hold."""
        return sum(plane.holds for plane in self.planes), sum(axis.holds for axis in self.axes)

    def scaled(self, scale: float) -> Symmetry:
        """Return the same in another unit, of which there are so many in the present one."""
        return replace(
            self,
            planes=tuple(replace(plane, offset=plane.offset * scale) for plane in self.planes),
            axes=tuple(replace(axis, point=axis.point * scale) for axis in self.axes),
            products=tuple(replace(product, residual=product.residual * scale**5) for product in self.products),
        )


def verdict_of(asymmetry: float, tolerance: float, facets: float) -> Verdict:
    """Return the verdict on an asymmetry where facets may have left out such a part of the volume."""
    if asymmetry <= tolerance:
        return "exact"
    if asymmetry > NEAR:
        return "none"
    return "within tessellation" if asymmetry <= 2 * facets else "near"
