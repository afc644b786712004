"""The mass properties that the shapes of a link give it."""

from __future__ import annotations

from dataclasses import dataclass

from robodyn.errors import InputError
from robodyn.robot.masses.measured import Reading
from robodyn.robot.masses.shapes import ShapesInertia, mesh_file, shapes_inertia
from robodyn.robot.urdf.geometry import Kind, link_named, link_shapes
from robodyn.robot.urdf.parts import Description
from robodyn.solids.inertia.properties import MassProperties
from robodyn.solids.mesh_mass import WATER
from robodyn.support.wording import shown


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
    """The composite body of a link's shapes in the link's frame, all of one density.

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
