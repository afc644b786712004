"""The mass properties of the shapes of a link, as solids of one density."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robodyn.errors import DescriptionError, RobodynError
from robodyn.robot.joints import placement
from robodyn.robot.masses.measured import MeshFile, Outcome
from robodyn.robot.urdf.geometry import Shape, missing_mesh
from robodyn.robot.urdf.parts import Description
from robodyn.solids.inertia import solids
from robodyn.solids.inertia.boxes import Box, around, counted_twice
from robodyn.solids.inertia.properties import MassProperties, composite
from robodyn.solids.mesh_mass import WATER, Part
from robodyn.support.floats import Floats

_SOLIDS: dict[str, Callable[..., MassProperties]] = {
    "box": solids.box,
    "cylinder": solids.cylinder,
    "sphere": solids.sphere,
    "capsule": solids.capsule,
}


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
    """The file that has to be read for a shape, if any."""
    return None if shape.path is None else (shape.path, shape.geometry.scale)


def shapes_inertia(
    description: Description, shapes: Sequence[Shape], meshes: Mapping[MeshFile, Outcome]
) -> ShapesInertia:
    """The composite body of shapes, closed forms and integrals over meshes, each at its pose.

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
        body = _SOLIDS[geometry.shape](*geometry.size, density=WATER)
    except RobodynError as error:
        raise DescriptionError(error.what, remedy=error.remedy, file=description.file, line=geometry.line) from None
    half = _half(geometry.shape, geometry.size)
    return body, Box(-half, half)


def _half(shape: str, size: Sequence[float]) -> Floats:
    if shape == "box":
        return np.array(size) / 2
    radius, length = size[0], size[1] if len(size) > 1 else 0.0
    end = {"cylinder": length / 2, "sphere": radius, "capsule": length / 2 + radius}[shape]
    return np.array((radius, radius, end))


def _remarks(part: Part) -> list[str]:
    name = part.name.replace("\\", "/").rpartition("/")[2]
    return [f"{name}: {text}" for text in (*(step.what for step in part.repairs), *part.warnings)]
