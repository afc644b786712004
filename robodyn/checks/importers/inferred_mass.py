"""The mass that MuJoCo infers for a link without an <inertial>: that of water in its collision shapes.

Run, MuJoCo 4.0 adds the shapes up at 1000 kg/m^3, what they share twice; of a mesh it takes the tetrahedra between each
triangle and the centre of the surface, all as positive. Of an .obj it takes the first object or group only. Shapes that
are only <visual> weigh nothing. With an <inertial>, be it of zeros, shapes do not count.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from functools import cache, partial
from math import fsum

import numpy as np

from robodyn.checks.context import Context
from robodyn.checks.meshes.files import mesh_names
from robodyn.errors import RobodynError
from robodyn.robot.urdf.view import GeometryView, LinkView
from robodyn.solids.inertia.solids import SHAPES, WATER
from robodyn.support.floats import Floats
from robodyn.support.input_file import read_input

_FACE, _OBJECT = re.compile(rb"^f[ \t]", re.MULTILINE), re.compile(rb"^[go]\b", re.MULTILINE)


def inferred_masses(context: Context, links: Iterable[LinkView]) -> Mapping[str, float | None]:
    """Masses [kg] of those links that have collision shapes and no <inertial>, by name; None where a shape is not
    known. Each is computed once."""
    of_shape, found = context.once(_of_shapes), dict[str, float | None]()
    for link in links:
        shapes = [shape for shape in link.geometries if shape.kind == "collision" and shape.shape is not None]
        if link.inertial is None and shapes:
            known = [mass for shape in shapes if (mass := of_shape(shape)) is not None]
            found[link.name] = fsum(known) if len(known) == len(shapes) else None
    return found


def _of_shapes(context: Context) -> Callable[[GeometryView], float | None]:
    return cache(partial(_of_shape, context))


def _of_shape(context: Context, shape: GeometryView) -> float | None:
    from robodyn.solids.mesh.read.load import load_triangles

    if shape.sizes:
        sizes = [value for size in shape.sizes for value in size.values or (0.0,)]
        return SHAPES[shape.tag](*sizes, density=WATER).mass if min(sizes) > 0 else None
    name = context.once(mesh_names).get(shape.uri)
    scale = shape.scale.or_default(1.0, 1.0, 1.0)
    if name is None or name.path is None or scale is None:
        return None
    try:
        if name.path.suffix.lower() == ".obj":
            data = read_input(name.path)
            face = _FACE.search(data)
            cut = None if face is None else _OBJECT.search(data, face.start())
            first = data[: cut.start()] if cut is not None and _FACE.search(data, cut.start()) else data
            triangles = load_triangles(first, file_type="obj")
        else:
            triangles = load_triangles(name.path)
        return _fan(triangles.array() * triangles.scale * np.array(scale))
    except (RobodynError, OSError):
        return None


def _fan(corners: Floats) -> float:
    """Mass of the tetrahedra between triangles (n, 3, 3) and the centre of their surface, as of water [kg]."""
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    whole = fsum(areas.tolist())
    if not whole:
        return 0.0
    v = corners - (areas[:, None] * corners.mean(axis=1)).sum(axis=0) / whole
    volumes = np.abs((v[:, 0] * np.cross(v[:, 1], v[:, 2])).sum(axis=1))
    return WATER / 6 * fsum(volumes.tolist())
