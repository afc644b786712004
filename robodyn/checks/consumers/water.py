"""What links weigh to MuJoCo: without an <inertial> as much as water in their collision shapes.

Run, MuJoCo 4.0 adds the shapes up at 1000 kg/m^3, what they share twice; of a mesh it takes the tetrahedra between each
triangle and the centre of the surface, all as positive: for closed surfaces that are seen from there as a whole, that
is their volume. Of an .obj it takes the first object or group only. Shapes that are only <visual> weigh nothing. With
an <inertial>, be it of zeros, shapes do not count.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from math import fsum
from typing import NamedTuple

import numpy as np

from robodyn.checks.bodies.masses import pose
from robodyn.checks.context import Context
from robodyn.checks.meshes.files import mesh_names
from robodyn.errors import RobodynError
from robodyn.programs.vectors import product
from robodyn.robot.kinematics import Pose
from robodyn.robot.urdf.view import GeometryView, LinkView
from robodyn.solids.inertia.laws import second_moments, symmetric
from robodyn.solids.inertia.solids import SHAPES, WATER
from robodyn.support.floats import Floats
from robodyn.support.input_file import read_input
from robodyn.support.sums import einsum

_FACE, _OBJECT = re.compile(rb"^f[ \t]", re.MULTILINE), re.compile(rb"^[go]\b", re.MULTILINE)


class Weight(NamedTuple):
    """Mass [kg], centre of mass (3,) [m], and second moments (3, 3) about it [kg m^2]."""

    mass: float
    centre: Floats
    S: Floats

    def placed(self, where: Pose) -> Weight:
        return Weight(self.mass, product(where.R, self.centre) + where.p, product(where.R, self.S, where.R.T))


NOTHING = Weight(0.0, np.zeros(3), np.zeros((3, 3)))


def joined(parts: Iterable[Weight]) -> Weight:
    """Return the composite body: the parallel axis theorem, part by part."""
    whole = NOTHING
    for part in parts:
        mass = whole.mass + part.mass
        share = part.mass / mass if mass else 0.0
        apart = part.centre - whole.centre
        S = whole.S + part.S + whole.mass * share * np.outer(apart, apart)
        whole = Weight(mass, whole.centre + share * apart, S)
    return whole


def compiler(context: Context) -> Mapping[str, str]:
    """Return the attributes of <mujoco><compiler>, by which a description tells MuJoCo how to read it."""
    extension = context.view.root.find("mujoco")
    element = None if extension is None else extension.find("compiler")
    return {} if element is None else element.values


def is_weighed(context: Context, link: LinkView) -> bool:
    """Return whether MuJoCo takes a link's mass from its collision shapes."""
    asked = context.once(compiler).get("inertiafromgeom", "auto")
    return asked != "false" and (link.inertial is None or asked == "true") and bool(_collisions(link))


def by_shapes(context: Context, link: LinkView) -> Weight | None:
    """Return what a link that is weighed so weighs; None where a shape is not known. Meshes are read once."""
    kept = context.once(_kept)
    if link.name not in kept:
        kept[link.name] = _of_shapes(context, link)
    return kept[link.name]


def _kept(context: Context) -> dict[str, Weight | None]:
    return {}


def weight_of(context: Context, link: LinkView) -> Weight | None:
    """Return what a link weighs: by shapes or <inertial>, nothing without either; None where that is not known."""
    if is_weighed(context, link):
        return by_shapes(context, link)
    return declared(link) if link.inertial is not None else NOTHING


def declared(link: LinkView) -> Weight | None:
    """Return what an <inertial> says, without mass where that is not positive; None where it cannot be read."""
    where = None if link.inertial is None else pose(link.inertial.origin)
    if where is None or link.mass is None or link.tensor is None:
        return None
    return Weight(max(link.mass, 0.0), np.zeros(3), second_moments(symmetric(link.tensor))).placed(where)


def inventions(context: Context, links: Iterable[LinkView]) -> Mapping[str, float | None]:
    """Return the masses that MuJoCo makes up for those links that have no <inertial>; None where a shape is not known.

    What stands still with the root has none to it.
    """
    found = {one.name: by_shapes(context, one) for one in links if one.inertial is None and is_weighed(context, one)}
    return {name: None if weight is None else weight.mass for name, weight in found.items()}


def invented(context: Context) -> Mapping[str, float | None]:
    """Return the masses that MuJoCo makes up, but for what stands still with the root."""
    return inventions(context, (link for group in context.tree.groups[1:] for link in group.links))


def _collisions(link: LinkView) -> list[GeometryView]:
    return [shape for shape in link.geometries if shape.kind == "collision" and shape.shape is not None]


def _of_shapes(context: Context, link: LinkView) -> Weight | None:
    parts = []
    for shape in _collisions(link):
        where, solid = pose(shape.origin), _of_primitive(shape) if shape.sizes else of_mesh(context, shape)
        if where is None or solid is None:
            return None
        parts.append(solid.placed(where))
    return joined(parts)


def _of_primitive(shape: GeometryView) -> Weight | None:
    sizes = [value for size in shape.sizes for value in size.values or (0.0,)]
    if shape.shape is None or min(sizes) <= 0:
        return None
    body = SHAPES[shape.shape.tag](*sizes, density=WATER)
    return Weight(body.mass, body.com, body.S_c)


def of_mesh(context: Context, shape: GeometryView) -> Weight | None:
    """Return what MuJoCo makes of a mesh; None where it cannot be read."""
    from robodyn.solids.mesh.read.load import load_triangles

    name = context.once(mesh_names).get((shape.shape and shape.shape.get("filename")) or "")
    scale = shape.scale.or_default(1.0, 1.0, 1.0)
    if name is None or name.path is None or scale is None:
        return None
    try:
        if name.path.suffix.lower() == ".obj":
            triangles = load_triangles(first_object(read_input(name.path)), file_type="obj")
        else:
            triangles = load_triangles(name.path)
        return _fan(triangles.array() * triangles.scale * np.array(scale))
    except (RobodynError, OSError):
        return None


def first_object(data: bytes) -> bytes:
    """Return an .obj up to its second object or group that has faces; all of it where there is none."""
    face = _FACE.search(data)
    cut = None if face is None else _OBJECT.search(data, face.start())
    return data[: cut.start()] if cut is not None and _FACE.search(data, cut.start()) else data


def _fan(corners: Floats) -> Weight:
    """Return the tetrahedra between triangles (n, 3, 3) and the centre of their surface, as of water."""
    areas = np.sqrt((np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) ** 2).sum(axis=1))
    whole = fsum(areas.tolist())
    if not whole:
        return NOTHING
    v = corners - (areas[:, None] * corners.mean(axis=1)).sum(axis=0) / whole
    masses = WATER / 6 * np.abs((v[:, 0] * np.cross(v[:, 1], v[:, 2])).sum(axis=1))
    mass, sums = fsum(masses.tolist()), v.sum(axis=1)
    centre = (masses[:, None] * sums).sum(axis=0) / (4 * mass) if mass else np.zeros(3)
    squares = einsum("nki,nkj->nij", v, v) + einsum("ni,nj->nij", sums, sums)
    S = (masses[:, None, None] * squares).sum(axis=0) / 20 - mass * np.outer(centre, centre)
    return Weight(mass, (areas[:, None] * corners.mean(axis=1)).sum(axis=0) / whole + centre, S)
