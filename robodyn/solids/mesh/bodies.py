"""Integrals of a surface, in units of its file, as a body of uniform density."""

from __future__ import annotations

from typing import TYPE_CHECKING

from robodyn.errors import MeshError
from robodyn.solids.inertia.conversions import from_integrals, from_surface_integrals
from robodyn.solids.inertia.properties import MassProperties
from robodyn.solids.mesh.integrate.integrals import Integrals
from robodyn.solids.mesh.integrate.sweep import surface
from robodyn.solids.mesh.triangles import Triangles

if TYPE_CHECKING:
    from robodyn.solids.mesh.region.quadrature import Quadrature


def solid(found: Integrals | Quadrature, triangles: Triangles, density: float) -> MassProperties:
    """Return what triangles enclose, or the region that was integrated in their place, at so many kg/m^3.

    Raises:
        MeshError: they enclose no volume.
    """
    if not found.volume:
        raise MeshError(
            "the surface encloses no volume", remedy="--shell THICKNESS takes it as a sheet", file=triangles.name
        )
    volume, first, second = found.moments
    return from_integrals(
        volume,
        first,
        second,
        density=density,
        reference=found.reference,
        scale=triangles.scale,
    )


def sheet(triangles: Triangles, density: float, thickness: float) -> MassProperties:
    """Return the triangles as a sheet of so many metres, at so many kg/m^3."""
    found = surface(triangles)
    return from_surface_integrals(
        found.area,
        found.first,
        found.S,
        density=density,
        thickness=thickness,
        reference=found.reference,
        scale=triangles.scale,
    )
