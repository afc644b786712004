"""A surface measured, as it is where it is proven sound, else after repair; as a body of uniform density; its shape."""

from __future__ import annotations

from dataclasses import dataclass, replace
from sys import float_info
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from robodyn.errors import MeshError
from robodyn.solids.inertia.properties import MassProperties, from_integrals, from_surface_integrals
from robodyn.solids.mesh.closed import Fingerprint, is_one_shell
from robodyn.solids.mesh.integrals import Integrals, VolumeIntegrals, measure, surface
from robodyn.solids.mesh.triangles import Triangles
from robodyn.support.input_file import VARIABLE, limits

if TYPE_CHECKING:
    from robodyn.solids.mesh.columns import Quadrature
    from robodyn.solids.mesh.repair import Repaired, Step
    from robodyn.solids.mesh.symmetry_search import Symmetry
    from robodyn.solids.mesh.tessellation import Tessellation


_FLAT = 1e-12
"""Volume over area and width below which a shell may have no sign: ten times what `nesting` asks."""

_COLLINEAR = 64 * float_info.epsilon
"""Area, over the square of the reach of the box, below which three corners may lie on a line: their edges from the
reference are exact within 2 eps, and the products of these within 35 eps."""


def is_sound(triangles: Triangles, integrals: Integrals, edges: Fingerprint) -> bool:
    """Return whether `robodyn.solids.mesh.repair` is sure to find nothing to do and nothing to say.

    So it is where the surface has no boundary, a volume that is positive beyond doubt, no triangle without area, and
    is one shell with exactly two triangles on every edge.
    """
    size = (integrals.hi - integrals.lo).max()
    return (
        edges.closed
        and bool(integrals.volume > _FLAT * integrals.area * size)
        and bool(integrals.least > _COLLINEAR * size**2)
        and is_one_shell(triangles)
    )


@dataclass(frozen=True, eq=False)
class Measured:
    """A surface after repair and its integrals; what was repaired, None if nothing had to be looked at."""

    triangles: Triangles
    integrals: Integrals
    closed: bool
    fixed: Repaired | None = None

    @property
    def region(self) -> Quadrature | None:
        """What the surface encloses where that is not the sum over its triangles."""
        return None if self.fixed is None else self.fixed.quadrature

    @property
    def defined(self) -> bool:
        """Whether the triangles themselves enclose the body."""
        return self.closed and self.region is None

    @property
    def remarks(self) -> tuple[str, ...]:
        return () if self.fixed is None else self.fixed.remarks

    @property
    def steps(self) -> tuple[Step, ...]:
        """The repairs, with volumes in m^3."""
        cube = self.triangles.scale**3
        steps = () if self.fixed is None else self.fixed.steps
        return tuple(
            replace(step, volume_before=step.volume_before * cube, volume_after=step.volume_after * cube)
            for step in steps
        )

    @property
    def union(self) -> float | None:
        """Relative error bar for overlaps and holes, None if there are none."""
        if self.region is not None:
            return self.region.bar
        doubt = 0.0 if self.fixed is None else self.fixed.doubt
        return doubt / abs(self.integrals.volume) if doubt else None


def measured(
    triangles: Triangles, *, exact: bool = False, repair: bool = True, strict: bool = False, cavities: bool = False
) -> Measured:
    """Return the surface as it is if it is proven sound, or if no repair is wanted; else put right and closed.

    Args:
        exact: integrate in exact arithmetic.
        strict: refuse what needs repair, and what may not be the whole mesh.
        cavities: see `repair`.

    Raises:
        MeshError: the surface needs repair and that is not wanted, or cannot be closed.
    """
    if strict and triangles.warnings:
        remedy = "--strict refuses what is doubtful"
        raise MeshError("; ".join(triangles.warnings), remedy=remedy, file=triangles.name)
    integrals, edges = measure(triangles, exact)
    if not repair or is_sound(triangles, integrals, edges):
        return Measured(triangles, integrals, edges.closed)
    from robodyn.solids.mesh.repair import repair as put_right

    fixed = put_right(triangles, cavities)
    if strict and fixed.steps:
        remedy = "--strict refuses what needs repair"
        raise MeshError("; ".join(step.what for step in fixed.steps), remedy=remedy, file=triangles.name)
    if not fixed.closed and fixed.quadrature is None:
        why = f" ({'; '.join(fixed.remarks)})" if fixed.remarks else ""
        raise MeshError(
            f"the surface is not closed{why}, so it encloses no definite volume",
            remedy="--shell THICKNESS takes it as a sheet, --no-repair integrates it as it is",
            file=triangles.name,
        )
    if fixed.triangles is not triangles:
        integrals, edges = measure(fixed.triangles, exact)
    return Measured(fixed.triangles, integrals, edges.closed, fixed)


def solid(found: VolumeIntegrals, triangles: Triangles, density: float) -> MassProperties:
    """Return what triangles enclose, or the region that was integrated in their place, at so many kg/m^3."""
    if not found.volume:
        raise MeshError(
            "the surface encloses no volume", remedy="--shell THICKNESS takes it as a sheet", file=triangles.name
        )
    return from_integrals(*found.moments, density=density, reference=found.reference, scale=triangles.scale)


def sheet(triangles: Triangles, density: float, thickness: float) -> MassProperties:
    """Return the triangles as a sheet of so many metres, at so many kg/m^3."""
    area, first, S, reference = surface(triangles)
    return from_surface_integrals(
        area, first, S, density=density, thickness=thickness, reference=reference, scale=triangles.scale
    )


SYMMETRY_TRIANGLES = 30_000
"""Up to which symmetry is sought unasked: a tenth of a second on most parts of that size."""

TESSELLATION_TRIANGLES = 100_000
"""Up to which facets are asked unasked: a tenth of a second."""

_LARGEST = 1 << 24
"""Bytes of an array that may be needed again and again: new memory for each would be a sixth of the time."""

_UNDEFINED = "symmetry and tessellation: not of sheets, and not of surfaces that are open or overlap themselves"


class Shape(NamedTuple):
    """Symmetry, in metres, and tessellation of a mesh, None where they were not sought; notes say why."""

    symmetry: Symmetry | None = None
    tessellation: Tessellation | None = None
    notes: tuple[str, ...] = ()


def shape(
    triangles: Triangles,
    integrals: Integrals,
    *,
    even: bool | None = None,
    smooth: bool | None = None,
    defined: bool = True,
    fixed_mass: bool = False,
) -> Shape:
    """Symmetry and tessellation error of a mesh that has a volume.

    Args:
        even: whether to seek symmetry, smooth: whether to ask facets; None: if there are few enough triangles.
        defined: whether the integrals are those of what the mesh encloses: it is closed and does not overlap itself.
        fixed_mass: see `tessellation`.
    """
    if not defined:
        return Shape(notes=() if (even, smooth) == (False, False) else (_UNDEFINED,))
    seek, notes_even = _wanted("symmetry", even, integrals.count, SYMMETRY_TRIANGLES)
    ask, notes_smooth = _wanted("tessellation", smooth, integrals.count, TESSELLATION_TRIANGLES)
    if not seek and not ask:
        return Shape(notes=notes_even + notes_smooth)
    from robodyn.solids.mesh.asymmetry import CentredBody
    from robodyn.solids.mesh.symmetry import symmetry
    from robodyn.solids.mesh.tessellation import tessellation

    np.empty(_LARGEST, np.uint8)  # glibc keeps the memory of arrays up to this size, once one of them is freed
    body = CentredBody.of(triangles, integrals)
    return Shape(
        symmetry(body).scaled(triangles.scale) if seek else None,
        tessellation(body.line_masses, integrals, body.centre, fixed_mass=fixed_mass) if ask else None,
        notes_even + notes_smooth,
    )


def _wanted(name: str, asked: bool | None, count: int, most: int) -> tuple[bool, tuple[str, ...]]:
    if asked and count > limits().mesh_shape:
        what = f"{name}: not sought above {limits().mesh_shape} triangles, for want of memory"
        return False, (f"{what} (simplify the mesh, or {VARIABLE}=mesh_shape=NUMBER allows more)",)
    if asked is not None or count <= most:
        return asked is not False, ()
    return False, (f"{name}: not sought unasked above {most} triangles (--{name} does)",)
