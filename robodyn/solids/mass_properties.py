"""Mass properties of meshes as solid parts or sheets, and of parts fixed to each other. The steps, in their order:

- `mesh/read/load`: the triangles of a file, whatever its type, in its own unit; `mesh/triangles` hands them out.
- `mesh/integrals`: volume, first and second moments with bounds, one pass by `mesh/kernel`, more digits where needed.
- `mesh/closed`: the surface is proven closed and one shell; then nothing is repaired.
- `mesh/repair`: else bad faces, winding, holes (`shells`, `holes`), nesting (`nesting`, `inside`), overlaps (`union`)
  are put right one after the other; what is no union of manifolds, or open, is integrated by `mesh/columns`.
- `mesh/measured`: these steps for one surface, and its integrals as a body at a density or a sheet of a thickness.
- `mesh/symmetry`: planes and axes (`symmetry_search`), judged by volumes (`asymmetry`); products that are 0 by them.
- `mesh/tessellation`: what facets leave out, told by the angles at their edges (`facets`).
- `inertia/properties`: mass, centre and second moments, moved by `inertia/laws`; `inertia/principal` has their axes,
  `inertia/validity` says whether a body can have them, `inertia/solids` closed forms.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from robodyn.errors import InputError, MeshError
from robodyn.programs.vectors import IDENTITY, ZERO
from robodyn.solids.inertia.properties import MassProperties, Pose, composite
from robodyn.solids.inertia.solids import WATER
from robodyn.solids.inertia.validity import Box, around, counted_twice
from robodyn.solids.mesh.integrals import Integrals
from robodyn.solids.mesh.measured import Shape, measured, shape, sheet, solid
from robodyn.solids.mesh.read.load import from_array, load_triangles
from robodyn.solids.mesh.triangles import Triangles, scaled
from robodyn.support.floats import Floats

if TYPE_CHECKING:
    from robodyn.solids.mesh.repair import Step
    from robodyn.solids.mesh.symmetry_search import Symmetry
    from robodyn.solids.mesh.tessellation import Tessellation


LONGEST = 20.0
"""Metres above which a part is suspected to be in millimetres: longer than any arm, shorter than a small part in mm."""


@dataclass(frozen=True, eq=False)
class Part:
    """Mass properties of a mesh.

    Attributes:
        body: mass, centre of mass and second moments, in the mesh's axes [kg, m].
        assumed: whether the density is assumed.
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
    _check(density, mass, shell)
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
    enclosed = found.region or integrals
    body = solid(enclosed, triangles, weight) if shell is None else sheet(triangles, weight, shell)
    form = shape(
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
        if form.symmetry is None:
            raise MeshError("has no symmetry to average over", remedy="; ".join(form.notes))
        from robodyn.solids.mesh.symmetry import symmetrized

        return symmetrized(body, form.symmetry)

    smooth = form.tessellation
    lo, hi = integrals.lo * triangles.scale, integrals.hi * triangles.scale
    warnings, longest = [*triangles.warnings], float((hi - lo).max())
    if longest > LONGEST:
        warnings.append(f"the part is {longest:.4g} m long: if the file is in millimetres, say --unit mm")
    if shell is None and not found.closed and found.region is None:
        warnings.append("the surface is not closed: its integral depends on where the origin is")
    return Part(
        name=triangles.name,
        triangles=integrals.count,
        body=replace(finished(body), area=integrals.area * triangles.scale**2),
        assumed=density is None and mass is None,
        lo=lo,
        hi=hi,
        closed=found.closed,
        repairs=found.steps,
        method=integrals.method,
        arithmetic=integrals.bound,
        rounding=_rounding(integrals, triangles),
        union=found.union,
        symmetry=form.symmetry,
        tessellation=smooth,
        corrected=None if smooth is None else finished(solid(smooth.corrected, triangles, weight)),
        warnings=(*warnings, *found.remarks),
        notes=triangles.notes + form.notes + _averaged(form, symmetrize),
    )


def _check(density: float | None, mass: float | None, shell: float | None) -> None:
    if density is not None and mass is not None:
        raise InputError("both a density and a mass are given", remedy="give one of them")
    for name, value, unit in (("density", density, "kg/m^3"), ("mass", mass, "kg"), ("thickness", shell, "m")):
        if value is not None and not 0 < value < np.inf:
            raise InputError(f"a {name} of {value:g} {unit} is not positive and finite")


def _averaged(found: Shape, symmetrize: bool) -> tuple[str, ...]:
    if not symmetrize or found.symmetry is None:
        return ()
    planes, axes = found.symmetry.accepted
    if not planes and not axes:
        return ("symmetrize: no plane and no axis holds, nothing was changed",)
    return (f"symmetrize: averaged over planes ({planes}) and axes ({axes}) of symmetry",)


def _rounding(integrals: Integrals, triangles: Triangles) -> float:
    """What moving every corner by half a unit in the last place of the file's largest coordinate does to the volume."""
    if not integrals.volume:
        return np.inf
    half = max(np.abs(integrals.lo).max(), np.abs(integrals.hi).max()) * 2.0**-triangles.significand
    return float(half * integrals.area / abs(integrals.volume))


HOME: Pose = (IDENTITY, ZERO)


@dataclass(frozen=True, eq=False)
class Combination:
    """Parts at their places, and the body that they make.

    Attributes:
        parts: as measured, each in its own axes; poses: of these in the common frame.
        body: in the common frame.
        box: around the parts, along the common axes.
        warnings: what is doubtful about the whole.
    """

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
    """Return the composite body of parts; see `composite`.

    Args:
        poses: of each part; all in the common frame as they are if empty.
        mass: of the whole [kg], in which the parts then share as they did.

    Raises:
        InputError: there are not as many poses as parts, or the mass is not positive.
    """
    if poses and len(poses) != len(parts):
        raise InputError(f"{len(poses)} places for {len(parts)} meshes", remedy="give one for each mesh, in order")
    where = tuple(poses) or (HOME,) * len(parts)
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
