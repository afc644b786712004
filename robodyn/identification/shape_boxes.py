"""Boxes around the shapes of a robot's bodies."""

from __future__ import annotations

import numpy as np

from robodyn.errors import MeshError
from robodyn.robot.load import placement
from robodyn.robot.masses.shapes import mesh_file
from robodyn.robot.model import Model
from robodyn.robot.urdf.geometry import Shape, link_shapes, missing_mesh
from robodyn.robot.urdf.parts import Description
from robodyn.solids.inertia.validity import Box, around, half_size
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.solids.mesh.triangles import scaled
from robodyn.support.wording import shown


def body_boxes(model: Model) -> tuple[dict[str, Box], tuple[str, ...]]:
    """Return a box around all shapes of each body that has some, along the axes of its frame, and notes.

    The shapes, visual and collision, of all links of a body count. Where one cannot be read the body has no box, since
    the others do not bound it; which is noted.
    """
    description = model.description
    assert description is not None, "models are made of descriptions"
    found: dict[int, list[Box]] = {}
    unread: dict[int, str] = {}
    for link, frame in model.links.items():
        shapes = link_shapes(description, link)
        try:
            boxes = [_box(description, shape).placed(frame.R, frame.p) for shape in shapes]
        except MeshError as error:
            unread[frame.body] = error.sentence
            continue
        found.setdefault(frame.body, []).extend(boxes)
    named = {model.bodies[body].name: around(boxes) for body, boxes in found.items() if boxes and body not in unread}
    notes = (f"shapes do not bound body {shown(model.bodies[body].name)}: {why}" for body, why in unread.items())
    return {name: box for name, box in named.items() if (box.hi > box.lo).any()}, tuple(notes)


def _box(description: Description, shape: Shape) -> Box:
    """Return the box around a shape, along the axes of its link.

    Raises:
        MeshError: the mesh is not found, cannot be read, or may not be the whole.
    """
    geometry, file = shape.geometry, mesh_file(shape)
    if shape.missing:
        raise MeshError(missing_mesh(description, geometry).what)
    if file is None:
        half = half_size(geometry.shape, geometry.size)
        return Box(-half, half).placed(*placement(geometry.origin))
    triangles = scaled(load_triangles(file[0]), file[1])
    if triangles.warnings:
        raise MeshError(triangles.warnings[0])
    ends = [end for block in triangles.blocks() for end in (block.min(axis=(0, 1)), block.max(axis=(0, 1)))]
    corners = np.array(ends, dtype=float) * triangles.scale
    return Box(corners.min(axis=0), corners.max(axis=0)).placed(*placement(geometry.origin))
