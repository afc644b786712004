"""The mass properties that its shapes give a link, as solids of one density."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from robodyn.errors import DescriptionError, InputError, RobodynError
from robodyn.robot.load import placement
from robodyn.robot.masses.measured import MeshFile, Outcome, Reading
from robodyn.robot.urdf.geometry import Shape, link_named, link_shapes, missing_mesh
from robodyn.robot.urdf.parts import Description, Kind
from robodyn.solids.inertia.properties import MassProperties, composite
from robodyn.solids.inertia.solids import SHAPES, WATER
from robodyn.solids.inertia.validity import Box, around, counted_twice, half_size
from robodyn.solids.mesh_mass import Part
from robodyn.support.wording import shown


@dataclass(frozen=True, eq=False)
class ShapesInertia:
    """The shapes of a link fixed to each other.

    Attributes:
        body: in the link's frame, of 1000 kg/m^3.
        box: around them, along the axes of the link's frame.
        parts: the meshes among them.
        remarks: what was repaired, what is doubtful.
    """

    body: MassProperties
    box: Box
    parts: tuple[Part, ...]
    remarks: tuple[str, ...]


def mesh_file(shape: Shape) -> MeshFile | None:
    """Return the file that has to be read for a shape, if any."""
    return None if shape.path is None else (shape.path, shape.geometry.scale)


def shapes_inertia(
    description: Description, shapes: Sequence[Shape], meshes: Mapping[MeshFile, Outcome]
) -> ShapesInertia:
    """Return the composite body of shapes, closed forms and integrals over meshes, each at its pose.

    What shapes share counts twice.

    Args:
        shapes: at least one.
        meshes: the parts of their `mesh_file`s.

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
            remarks += _remarks(part)
        elif shape.missing:
            raise missing_mesh(description, shape.geometry)
        else:
            body, box = _solid(description, shape)
        placed.append((body, pose))
        boxes.append(box.placed(*pose))
    return ShapesInertia(composite(placed), around(boxes), tuple(parts), (*remarks, *counted_twice(boxes)))


def _solid(description: Description, shape: Shape) -> tuple[MassProperties, Box]:
    geometry = shape.geometry
    try:
        body = SHAPES[geometry.shape](*geometry.size, density=WATER)
    except RobodynError as error:
        raise DescriptionError(error.what, remedy=error.remedy, file=description.file, line=geometry.line) from None
    half = half_size(geometry.shape, geometry.size)
    return body, Box(-half, half)


def _remarks(part: Part) -> list[str]:
    name = part.name.replace("\\", "/").rpartition("/")[2]
    return [f"{name}: {text}" for text in (*(step.what for step in part.repairs), *part.warnings)]


@dataclass(frozen=True, eq=False)
class LinkShapes:
    """A link made of its shapes.

    Attributes:
        name, line: of the link; kind: "visual" or "collision".
        body: in the link's frame.
        weight: where its mass is from, in words.
        shapes: the same at 1000 kg/m^3, with remarks.
    """

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
        reading: how meshes are read.

    Raises:
        InputError: there is no such link, it has no such shape, or density and mass are both given or not positive.
        MeshError: a mesh is no solid.
        DescriptionError: the file of a mesh is not found.
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
