"""The mass properties that its shapes give a link, of one density, and how what is declared differs from them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

import numpy as np

from robodyn.errors import DescriptionError, InputError, MeshError, RobodynError
from robodyn.programs.vectors import length, product
from robodyn.robot.load import placement
from robodyn.robot.masses.declared import LinkInertia, declared
from robodyn.robot.masses.mistakes import Given, Uniform, mistake_posterior, relative
from robodyn.robot.urdf.description import Shape, link_named, link_shapes, missing_mesh
from robodyn.robot.urdf.parts import Description, Inertial, Kind, Vector
from robodyn.solids.inertia.properties import MassProperties, composite
from robodyn.solids.inertia.solids import SHAPES, WATER
from robodyn.solids.inertia.validity import PRINTED, Box, around, box_bound, counted_twice, half_size
from robodyn.solids.mass_properties import Part, mass_properties
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.support.floats import Floats, ranked
from robodyn.support.threads import in_threads
from robodyn.support.wording import one_of, shown

MeshFile = tuple[Path, Vector]
"""A file, and the scale to read it with."""

Outcome = Part | RobodynError
Watch = Callable[[Sequence[Path]], AbstractContextManager[Callable[[], object]]]
"""What makes, for files that are going to be read, a function to call after each of them."""
UNCERTAIN = 1e-12
"""Relative differences below this are none: rounding makes them."""


class How(TypedDict, total=False):
    """Options of `mass_properties` that hold for every mesh."""

    exact: bool
    repair: bool
    strict: bool
    cavities: bool


@dataclass(frozen=True)
class Reading:
    """How meshes are read; `watch` is told of the files, and of each that is done."""

    how: How
    watch: Watch = lambda files: nullcontext(lambda: None)

    def parts(self, files: Iterable[MeshFile]) -> dict[MeshFile, Outcome]:
        """Return the part that each mesh is at the density 1000 kg/m^3, or why it is none; each is read once."""
        wanted = list(dict.fromkeys(files))
        with self.watch([path for path, _ in wanted]) as tick:

            def measure(file: MeshFile) -> Outcome:
                try:
                    triangles = load_triangles(file[0])
                    return mass_properties(triangles, scale=file[1], symmetry=False, tessellation=False, **self.how)
                except RobodynError as error:
                    return error
                finally:
                    tick()

            return dict(zip(wanted, in_threads(measure, wanted), strict=True))


@dataclass(frozen=True, eq=False)
class ShapesInertia:
    """The shapes of a link fixed to each other, of 1000 kg/m^3, and the box around them, in the link's frame; meshes
    among them, and what was repaired or is doubtful."""

    body: MassProperties
    box: Box
    parts: tuple[Part, ...]
    remarks: tuple[str, ...]


def mesh_file(shape: Shape) -> MeshFile | None:
    return None if shape.path is None else (shape.path, shape.geometry.scale)


def shapes_inertia(
    description: Description, shapes: Sequence[Shape], meshes: Mapping[MeshFile, Outcome]
) -> ShapesInertia:
    """Return the composite body of one or more shapes, each at its pose; what they share counts twice. `meshes` has the
    parts of their `mesh_file`s.

    Raises:
        RobodynError: the file of a mesh is not found, a mesh is no solid, or a length is negative.
    """
    placed, boxes, parts, remarks = [], [], [], list[str]()
    for shape in shapes:
        pose = placement(shape.geometry.origin)
        file = mesh_file(shape)
        if file is not None:
            part = meshes[file]
            if isinstance(part, RobodynError):
                raise part
            body, box = part.body, Box(part.lo, part.hi)
            parts.append(part)
            name = part.name.replace("\\", "/").rpartition("/")[2]
            remarks += [f"{name}: {text}" for text in (*(step.what for step in part.repairs), *part.warnings)]
        elif shape.missing:
            raise missing_mesh(description, shape.geometry)
        else:
            geometry = shape.geometry
            try:
                body = SHAPES[geometry.shape](*geometry.size, density=WATER)
            except RobodynError as error:
                at = {"remedy": error.remedy, "file": description.file}
                raise DescriptionError(error.what, line=geometry.line, **at) from None
            half = half_size(geometry.shape, geometry.size)
            box = Box(-half, half)
        placed.append((body, pose))
        boxes.append(box.placed(*pose))
    return ShapesInertia(composite(placed), around(boxes), tuple(parts), (*remarks, *counted_twice(boxes)))


@dataclass(frozen=True, eq=False)
class LinkShapes:
    """A link of its shapes, in its own frame: `shapes` at 1000 kg/m^3, and the `body` of the mass from where `weight`
    says."""

    name: str
    line: int
    kind: Kind
    body: MassProperties
    weight: str
    shapes: ShapesInertia


def link_from_shapes(
    description: Description,
    name: str,
    kind: Kind = "visual",
    *,
    density: float | None = None,
    mass: float | None = None,
    reading: Reading | None = None,
) -> LinkShapes:
    """Return the composite body of a link's shapes in the link's frame, all of one density.

    Args:
        density: kg/m^3; mass: of the link [kg]; by default the mass that the description declares, if it is positive,
            otherwise the density 1000 kg/m^3.

    Raises:
        InputError: there is no such link, it has no such shape, or density and mass are both given or not positive.
        RobodynError: as `shapes_inertia`.
    """
    link = link_named(description, name)
    shapes = link_shapes(description, name, kind)
    if not shapes:
        what = f"link {shown(name)} has no <{kind}> shape"
        raise InputError(what, remedy="choose another --geometry", file=description.file, line=link.line)
    if density is not None and mass is not None:
        raise InputError("both a density and a mass are given", remedy="give one of them")
    for what, value, unit in (("density", density, "kg/m^3"), ("mass", mass, "kg")):
        if value is not None and not 0 < value < float("inf"):
            raise InputError(f"a {what} of {value:g} {unit} is not positive and finite")
    files = [file for shape in shapes if (file := mesh_file(shape))]
    found = shapes_inertia(description, shapes, (reading or Reading({})).parts(files))
    body, weight = found.body, "at an assumed density"
    if density is not None:
        body, weight = body.scaled_to_mass(body.mass * density / WATER), "by the density"
    elif mass is not None:
        body, weight = body.scaled_to_mass(mass), "as asked"
    elif link.inertial is not None and link.inertial.mass > 0:
        body, weight = body.scaled_to_mass(link.inertial.mass), "as declared"
    return LinkShapes(name, link.line, kind, body, weight, found)


@dataclass(frozen=True, eq=False)
class Difference:
    """How far declared properties are from those of the shapes at the same mass.

    Attributes:
        body: of the shapes, at the declared mass, in the link's frame; density: that this gives them [kg/m^3].
        offset: (3,) from the centre of mass of the shapes to the declared one, `distance` its length [m].
        ratios: (3,) of declared to shapes' principal moments, both ascending.
        inertia: `relative` distance of the inertias about the centres of mass.
        room: above 1 no distribution of mass inside the box around the shapes is possible; see `box_bound`.
        slip: what explains the difference, if anything does.
    """

    body: MassProperties
    density: float
    offset: Floats
    ratios: Floats
    inertia: float
    room: float
    slip: tuple[str, ...]
    shapes: ShapesInertia

    @property
    def distance(self) -> float:
        return length(self.offset)


@dataclass(frozen=True, eq=False)
class LinkComparison:
    """One link: what it declares, and the difference to its shapes or the reason why there is none."""

    name: str
    line: int
    shapes: tuple[Shape, ...]
    declared: LinkInertia | None
    difference: Difference | None
    reason: str | None

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is impossible, and what is doubtful about the meshes."""
        found = () if self.declared is None else self.declared.faults
        if self.difference is None:
            return found
        room = self.difference.room
        if room == np.inf:
            found += ("the centre of mass lies outside the box around the shapes",)
        elif room > 1 + PRINTED:
            found += (f"spread over {room:.3g} times what any mass inside the box around the shapes can be",)
        return found + self.difference.slip + self.difference.shapes.remarks


@dataclass(frozen=True, eq=False)
class Comparison:
    """The links of a robot that have mass or shapes, the most different first, those that were not compared last; those
    that differ equally, or by no more than rounding, in the order of the description."""

    name: str
    file: str
    kind: Kind
    links: tuple[LinkComparison, ...]


def compare(description: Description, kind: Kind = "visual", reading: Reading | None = None) -> Comparison:
    """Return declared against shape-derived mass properties; shapes have one density per link, by the mass."""
    shapes = {link.name: link_shapes(description, link.name, kind) for link in description.links}
    wanted = [link for link in description.links if link.inertial or shapes[link.name]]
    files = [file for link in wanted if link.inertial for shape in shapes[link.name] if (file := mesh_file(shape))]
    meshes = (reading or Reading({})).parts(files)
    links = []
    for link in wanted:
        given, own = declared(link), shapes[link.name]
        difference, reason = None, None
        if given is None or link.inertial is None:
            reason = "no <inertial>"
        elif not own:
            reason = f"no <{kind}> shape"
        elif not given.body.mass > 0:
            reason = f"a mass of {given.body.mass:g} kg"
        else:
            try:
                difference = _difference(given.body, link.inertial, shapes_inertia(description, own, meshes))
            except RobodynError as error:
                at = error.file if isinstance(error, MeshError) else None  # no remedy, for a mesh in a command
                reason = error.what if at is None else f"{Path(at).name}: {error.what}"
        links.append(LinkComparison(link.name, link.line, own, given, difference, reason))
    ordered = ranked(links, lambda link: link.difference.inertia if link.difference else -1.0, UNCERTAIN)
    return Comparison(description.name, description.file, kind, tuple(ordered))


def _difference(given: MassProperties, inertial: Inertial, shapes: ShapesInertia) -> Difference:
    body = shapes.body.scaled_to_mass(given.mass)
    if not (body.principal.moments > 0).all():
        raise InputError("the shapes are too small for floats")
    with np.errstate(over="ignore", invalid="ignore"):
        offset, ratios = given.com - body.com, given.principal.moments / body.principal.moments
        apart, density = relative(given.inertia, body.inertia), given.mass / float(shapes.body.volume or np.inf)
        figures = (*ratios, apart, density, length(offset))
    if not np.isfinite(figures).all():
        raise InputError("the declared numbers are too large for a comparison")
    return Difference(
        body=body,
        density=density,
        offset=offset,
        ratios=ratios,
        inertia=apart,
        room=float(box_bound(given, *shapes.box).max()),
        slip=mistakes_in_words(inertial, shapes.body),
        shapes=shapes,
    )


def mistakes_in_words(inertial: Inertial, shapes: MassProperties) -> tuple[str, ...]:
    """Return in words the mistake that explains an inertial of positive mass by shapes of one density, in the link's
    frame."""
    R, p = placement(inertial.origin)
    if not any(inertial.inertia) or not shapes.volume:
        return ()
    given = Given(inertial.mass, product(R.T, p), R, inertial.inertia)
    found = mistake_posterior(given, Uniform(shapes.volume, shapes.com, shapes.S_c / shapes.mass).along(R))
    if not found.named:
        either = one_of([one.what for one in found.either])
        return () if either is None else (either,)
    first = found.named[0]
    others = [one.what for one in found.named[1:] if relative(one.I, first.I) > 0.02]  # nearer ones are one
    agrees = f"corrected, the inertia agrees within {max(100 * first.apart, 0.1):.1f} %"
    return (f"{' or '.join(dict.fromkeys((first.what, *others)))}: {agrees}",)
