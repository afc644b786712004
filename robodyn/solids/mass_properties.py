"""Mass properties of meshes as solid parts or sheets, and of parts fixed to each other. The steps, in their order:

- `mesh/read/load`: the triangles of a file, whatever its type, in its own unit; `mesh/triangles` hands them out.
- `mesh/integrals`: volume, first and second moments with bounds, one pass by `mesh/kernel`, more digits where needed.
- `mesh/closed`: the surface is proven closed and one shell; then nothing is repaired.
- `mesh/repair`: else bad faces, winding, holes (`shells`, `holes`), nesting (`nesting`, `inside`), overlaps
  are put right one after the other; what is no union of manifolds, or open, is integrated by `mesh/columns`.
- `measured`: these steps for one surface.
- `mesh/symmetry`: planes and axes (`symmetry_search`), judged by volumes (`asymmetry`); products that are 0 by them.
- `mesh/tessellation`: what facets leave out, told by the angles at their edges.
- `inertia/properties`: mass, centre, second moments and their axes, moved by `inertia/laws`; `inertia/validity` says
  whether a body can have them, `inertia/solids` has closed forms.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from sys import float_info
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robodyn.errors import InputError, MeshError
from robodyn.programs.vectors import IDENTITY, ZERO
from robodyn.solids.inertia.properties import MassProperties, Pose, composite, from_integrals, from_surface_integrals
from robodyn.solids.inertia.solids import WATER
from robodyn.solids.inertia.validity import Box, around, counted_twice
from robodyn.solids.mesh.closed import Fingerprint, is_one_shell
from robodyn.solids.mesh.integrals import Integrals, VolumeIntegrals, measure, surface
from robodyn.solids.mesh.read.load import from_array, load_triangles
from robodyn.solids.mesh.triangles import Triangles, scaled
from robodyn.support.floats import Floats
from robodyn.support.input_file import VARIABLE, limits

if TYPE_CHECKING:
    from robodyn.solids.mesh.columns import Quadrature
    from robodyn.solids.mesh.repair import Step
    from robodyn.solids.mesh.symmetry_search import Symmetry
    from robodyn.solids.mesh.tessellation import Tessellation


LONGEST = 20.0
"""Metres above which a part is suspected to be in millimetres: longer than any arm, shorter than a small part in mm."""
_FLAT = 1e-12
"""Volume over area and width below which a shell may have no sign: ten times what `nesting` asks."""
_COLLINEAR = 64 * float_info.epsilon
"""Area, over the square of the reach of the box, below which three corners may lie on a line: their edges from the
reference are exact within 2 eps, and the products of these within 35 eps."""


@dataclass(frozen=True, eq=False)
class Part:
    """Mass properties of a mesh.

    Attributes:
        body: in the mesh's axes [kg, m]; assumed: whether its density is.
        lo, hi: (3,) corners of its box [m].
        closed: whether the surface has no boundary, so that the integral does not depend on the origin.
        repairs: what was changed before the mesh was integrated, with signed volumes in m^3.
        method: the arithmetic that was needed: "float64", "long double" or "rational".
        union: relative error bar for overlaps and holes, None if there are none: of the volume, and where that was not
            integrated by triangles also of the second moments about the centre.
        arithmetic, rounding: relative errors of the volume: a bound of that of computing, and what the file's rounding
            of coordinates can make of it.
        symmetry: planes and axes of the mesh, in metres; None where they were not sought.
        tessellation: how far the numbers may be from those of the smooth body that facets stand for, and corrected:
            that body; None where it was not asked.
        warnings: what is doubtful; notes: what was assumed when the file was read, and what was not sought.
    """

    name: str
    triangles: int
    body: MassProperties
    assumed: bool
    lo: Floats
    hi: Floats
    closed: bool
    repairs: tuple[Step, ...]
    method: str
    arithmetic: float
    rounding: float
    union: float | None
    symmetry: Symmetry | None
    tessellation: Tessellation | None
    corrected: MassProperties | None
    warnings: tuple[str, ...]
    notes: tuple[str, ...]


def mass_properties(
    source: str | os.PathLike[str] | bytes | ArrayLike | Triangles,
    *,
    density: float | None = None,
    mass: float | None = None,
    unit: str | None = None,
    file_type: str | None = None,
    exact: bool = False,
    repair: bool = True,
    strict: bool = False,
    cavities: bool = False,
    shell: float | None = None,
    scale: Sequence[float] = (1.0, 1.0, 1.0),
    symmetry: bool | None = False,
    symmetrize: bool = False,
    tessellation: bool | None = False,
) -> Part:
    """Mass, centre of mass and inertia of what a mesh encloses, as a body of uniform density.

    The integrals are sums over tetrahedra; that the surface is closed is proven by its boundary chain. What is wrong
    with it is repaired where that can be done, and said.

    Args:
        source: name of a mesh file, `-` for standard input, its bytes, or triangles, (m, 3, 3) or loaded.
        density: kg/m^3; 1000 if neither this nor the mass is given.
        mass: kg, in place of a density.
        unit: "m", "mm", "cm" or "in"; by default what the file says, or metres.
        file_type: "stl", "obj", "ply" and so on; by default by the suffix.
        exact: integrate in exact arithmetic.
        repair: False takes the signed integral of the surface as it is, with a warning if it is not closed; shells that
            overlap then count twice.
        strict: refuse a mesh that needs repair, or may not be the whole one.
        cavities: shells in others are cavities, however they are wound; by default one that is wound as the body around
            it is a part of that.
        shell: thickness [m]: the surface is taken as a sheet of this thickness, closed or not.
        scale: factors along the mesh's axes, as URDF's <mesh> has them; negative ones give a mirror image.
        symmetry, tessellation: whether to seek symmetry, and to ask what facets leave out; None, as the command has it:
            where triangles are few.
        symmetrize: average the body over the planes and axes of symmetry that hold (see `symmetrized`).

    Raises:
        InputError: density, mass or thickness is not positive, or both of the first two are given.
        MeshError: the mesh cannot be read, is not closed, or encloses no volume.

    Accuracy: centre of mass and inertia of the triangles as given within 1e-12, and within 1e-15 at most offsets and
        shapes; correctly rounded if `exact`.
    """
    if density is not None and mass is not None:
        raise InputError("both a density and a mass are given", remedy="give one of them")
    for name, value, in_units in (("density", density, "kg/m^3"), ("mass", mass, "kg"), ("thickness", shell, "m")):
        if value is not None and not 0 < value < np.inf:
            raise InputError(f"a {name} of {value:g} {in_units} is not positive and finite")
    if cavities and not repair:
        raise InputError("cavities are told from bodies by repair", remedy="leave out --cavities or --no-repair")
    if isinstance(source, (str, os.PathLike, bytes)):
        source = load_triangles(source, file_type=file_type, unit=unit, typed=True)
    elif not isinstance(source, Triangles):
        source = from_array(source, unit=unit or "m")
    triangles = scaled(source, scale)
    found = measured(triangles, exact=exact, repair=repair and shell is None, strict=strict, cavities=cavities)
    triangles, integrals = found.triangles, found.integrals
    weight = WATER if density is None else density
    if shell is None:
        body = _solid(found.region or integrals, triangles, weight)
    else:
        area, first, S, reference = surface(triangles)
        body = from_surface_integrals(
            area, first, S, density=weight, thickness=shell, reference=reference, scale=triangles.scale
        )
    planes_and_axes, smooth, notes = _shape(
        triangles,
        integrals,
        even=symmetrize or symmetry,
        smooth=tessellation,
        defined=shell is None and found.defined,
        fixed_mass=mass is not None,
    )

    def finished(body: MassProperties) -> MassProperties:
        """Return the body at its mass, and averaged."""
        if mass is not None:
            body = body.scaled_to_mass(mass)
        if not symmetrize:
            return body
        if planes_and_axes is None:
            raise MeshError("has no symmetry to average over", remedy="; ".join(notes))
        from robodyn.solids.mesh.symmetry import symmetrized

        return symmetrized(body, planes_and_axes)

    body = replace(finished(body), area=integrals.area * triangles.scale**2)
    if symmetrize and planes_and_axes is not None:
        planes, axes = planes_and_axes.accepted
        done = f"averaged over planes ({planes}) and axes ({axes}) of symmetry"
        done = done if planes or axes else "no plane and no axis holds, nothing was changed"
        notes = (*notes, f"symmetrize: {done}")
    lo, hi = integrals.lo * triangles.scale, integrals.hi * triangles.scale
    warnings, longest = [*triangles.warnings], float((hi - lo).max())
    if longest > LONGEST:
        warnings.append(f"the part is {longest:.4g} m long: if the file is in millimetres, say --unit mm")
    if shell is None and not found.closed and found.region is None:
        warnings.append("the surface is not closed: its integral depends on where the origin is")
    # every corner moved by half a unit in the last place of the file's largest coordinate
    half = max(np.abs(integrals.lo).max(), np.abs(integrals.hi).max()) * 2.0**-triangles.significand
    rounding, union = np.inf, None
    if integrals.volume:
        rounding = float(half * integrals.area / abs(integrals.volume))
        union = found.doubt / abs(integrals.volume) or None
    return Part(
        name=triangles.name,
        triangles=integrals.count,
        body=body,
        assumed=density is None and mass is None,
        lo=lo,
        hi=hi,
        closed=found.closed,
        repairs=found.steps,
        method=integrals.method,
        arithmetic=integrals.bound,
        rounding=rounding,
        union=union if found.region is None else found.region.bar,
        symmetry=planes_and_axes,
        tessellation=smooth,
        corrected=None if smooth is None else finished(_solid(smooth.corrected, triangles, weight)),
        warnings=(*warnings, *found.remarks),
        notes=triangles.notes + notes,
    )


def is_sound(triangles: Triangles, integrals: Integrals, edges: Fingerprint) -> bool:
    """Return whether `robodyn.solids.mesh.repair` is sure to find nothing to do and nothing to say. So it is where the
    surface has no boundary, a volume that is positive beyond doubt, no triangle without area, and is one shell with
    exactly two triangles on every edge."""
    size = (integrals.hi - integrals.lo).max()
    return (
        edges.closed
        and bool(integrals.volume > _FLAT * integrals.area * size)
        and bool(integrals.least > _COLLINEAR * size**2)
        and is_one_shell(triangles)
    )


class Measured(NamedTuple):
    """A surface after repair and its integrals.

    region: what it encloses where that is not the sum over its triangles; steps: the repairs, with volumes in m^3;
    doubt: volume that may be missing or too much where holes were filled, in the unit of the file.
    """

    triangles: Triangles
    integrals: Integrals
    closed: bool
    region: Quadrature | None = None
    steps: tuple[Step, ...] = ()
    remarks: tuple[str, ...] = ()
    doubt: float = 0.0

    @property
    def defined(self) -> bool:
        """Whether the triangles themselves enclose the body."""
        return self.closed and self.region is None


def measured(
    triangles: Triangles, *, exact: bool = False, repair: bool = True, strict: bool = False, cavities: bool = False
) -> Measured:
    """Return the surface as it is if it is proven sound, or if no repair is wanted; else put right and closed. Options
    as of `mass_properties`; raises MeshError where the surface needs repair and that is not wanted, or cannot be
    closed."""
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
    cube = triangles.scale**3
    steps = tuple(
        replace(step, volume_before=step.volume_before * cube, volume_after=step.volume_after * cube)
        for step in fixed.steps
    )
    return Measured(fixed.triangles, integrals, edges.closed, fixed.quadrature, steps, fixed.remarks, fixed.doubt)


def _solid(found: VolumeIntegrals, triangles: Triangles, density: float) -> MassProperties:
    """Return what triangles enclose, or the region that was integrated in their place, at so many kg/m^3."""
    if not found.volume:
        raise MeshError(
            "the surface encloses no volume", remedy="--shell THICKNESS takes it as a sheet", file=triangles.name
        )
    return from_integrals(*found.moments, density=density, reference=found.reference, scale=triangles.scale)


SYMMETRY_TRIANGLES = 30_000
"""Up to which symmetry is sought unasked: a tenth of a second on most parts of that size."""
TESSELLATION_TRIANGLES = 100_000
"""Up to which facets are asked unasked: a tenth of a second."""
_LARGEST = 1 << 24
"""Bytes of an array that may be needed again and again: new memory for each would be a sixth of the time."""
_UNDEFINED = "symmetry and tessellation: not of sheets, and not of surfaces that are open or overlap themselves"


def _shape(
    triangles: Triangles,
    integrals: Integrals,
    *,
    even: bool | None,
    smooth: bool | None,
    defined: bool,
    fixed_mass: bool,
) -> tuple[Symmetry | None, Tessellation | None, tuple[str, ...]]:
    """Return symmetry, in metres, and tessellation error of a mesh, None where they are not sought; notes say why.
    even, smooth: whether to seek symmetry, to ask facets, None where triangles are few; defined: whether the integrals
    are those of what the mesh encloses."""
    if not defined:
        return None, None, () if (even, smooth) == (False, False) else (_UNDEFINED,)
    seek, notes_even = _wanted("symmetry", even, integrals.count, SYMMETRY_TRIANGLES)
    ask, notes_smooth = _wanted("tessellation", smooth, integrals.count, TESSELLATION_TRIANGLES)
    if not seek and not ask:
        return None, None, notes_even + notes_smooth
    from robodyn.solids.mesh.asymmetry import CentredBody
    from robodyn.solids.mesh.symmetry import symmetry
    from robodyn.solids.mesh.tessellation import tessellation

    np.empty(_LARGEST, np.uint8)  # glibc keeps the memory of arrays up to this size, once one of them is freed
    body = CentredBody.of(triangles, integrals)
    return (
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


@dataclass(frozen=True, eq=False)
class Combination:
    """Parts as measured, each in its own axes, their poses in the common frame, and the body that they make in it."""

    parts: tuple[Part, ...]
    poses: tuple[Pose, ...]
    body: MassProperties
    box: Box
    warnings: tuple[str, ...]

    @property
    def placed(self) -> tuple[MassProperties, ...]:
        """The parts' bodies in the common frame."""
        return tuple(part.body.placed(*pose) for part, pose in zip(self.parts, self.poses, strict=True))


def combined(parts: Sequence[Part], poses: Sequence[Pose] = (), mass: float | None = None) -> Combination:
    """Return the composite body of parts, all as they are in the common frame if there are no poses; see `composite`.
    In a `mass` of the whole [kg] the parts share as they did. InputError where there are not as many poses as parts, or
    the mass is not positive."""
    if poses and len(poses) != len(parts):
        raise InputError(f"{len(poses)} places for {len(parts)} meshes", remedy="give one for each mesh, in order")
    where = tuple(poses) or ((IDENTITY, ZERO),) * len(parts)
    body = composite(zip((part.body for part in parts), where, strict=True))
    if mass is not None:
        if not 0 < mass < float("inf"):
            raise InputError(f"a mass of {mass:g} kg is not positive and finite")
        weighed = []
        for part in parts:
            share = mass * part.body.mass / body.mass
            smooth = part.corrected and part.corrected.scaled_to_mass(share)
            weighed.append(replace(part, body=part.body.scaled_to_mass(share), corrected=smooth, assumed=False))
        parts, body = weighed, body.scaled_to_mass(mass)
    boxes = [Box(part.lo, part.hi).placed(*pose) for part, pose in zip(parts, where, strict=True)]
    return Combination(tuple(parts), where, body, around(boxes), counted_twice(boxes))
