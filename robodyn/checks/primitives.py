"""The box around a link's shapes, where all of them are primitives whose size the file says."""

from __future__ import annotations

import numpy as np

from robodyn.checks.frames import pose
from robodyn.checks.view import GeometryView, LinkView, numbers
from robodyn.programs.vectors import product
from robodyn.solids.inertia.boxes import Box, around
from robodyn.solids.inertia.exact import Floats


def own_box(link: LinkView, R: Floats) -> Box | None:
    """The box along the axes R (3, 3) of the link's frame, about its origin [m]; None where a mesh or nothing is there.

    A primitive is bounded by the box around it in its own axes, which is exact for boxes.
    """
    boxes = [_box(geometry, R) for geometry in link.geometries]
    known = [box for box in boxes if box is not None]
    return around(known) if known and len(known) == len(boxes) else None


def _box(geometry: GeometryView, R: Floats) -> Box | None:
    placed, half = pose(geometry.origin), half_size(geometry)
    if placed is None or half is None:
        return None
    return Box(-half, half).placed(product(R.T, placed.R), product(R.T, placed.p))


def half_size(geometry: GeometryView) -> Floats | None:
    """Half the sizes (3,) of a primitive in its own axes [m]; None of a mesh, or where a size cannot be read."""
    shape = geometry.shape
    if shape is None or shape.tag == "mesh":
        return None
    if shape.tag == "box":
        size = numbers(shape, "size", 3).values
        return None if size is None else np.array(size) / 2.0
    radius, length = numbers(shape, "radius", 1).value, numbers(shape, "length", 1).value
    if shape.tag == "sphere":
        length = 0.0
    if radius is None or length is None:
        return None
    cap = 0.0 if shape.tag == "cylinder" else radius
    return np.array((radius, radius, length / 2.0 + cap))
