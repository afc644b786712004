"""Links of SDF: their inertial, as written or by the density of their collisions, and their shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import cast

from robodyn.errors import InputError, RobodynError
from robodyn.programs.vectors import IDENTITY, rpy_from_rotation
from robodyn.robot.sdf.frames import HERE, Frames, Node, Pose, composed, relative, truth
from robodyn.robot.urdf import parts
from robodyn.robot.urdf.document import Element
from robodyn.robot.urdf.parts import Geometry, Inertial, Kind, Link, Origin, Vector
from robodyn.robot.urdf.sources import package_of
from robodyn.solids.inertia.properties import MassProperties, composite
from robodyn.solids.inertia.solids import SHAPES, WATER
from robodyn.solids.mass_properties import mass_properties
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.support.floats import Floats

_KINDS = ("visual", "collision")


def link_of(node: Node, frames: Frames, moved: Pose) -> Link:
    """Return a link whose frame in SDF stands at `moved` in that of the description; without <inertial> it has 1 kg."""
    shapes = [(each, _placed(each, node, frames)) for each in node.element.children if each.tag in _KINDS]
    geometries = []
    for each, pose in shapes:
        if (shape := _shape(each, node, frames)) is not None:
            geometries.append(replace(shape, origin=origin(composed(moved, pose))))
    written = node.child("inertial", node.element)
    if written is not None and truth(written.get("auto") or ""):
        body = _weighed(written, node, frames, [shape for shape in shapes if shape[0].tag == "collision"])
        mass, pose, I = body.mass, (IDENTITY, body.com), body.inertia
        entries = [float(I["xyz".index(tag[1]), "xyz".index(tag[2])]) for tag in parts.INERTIA]
    else:
        mass, inertia = node.number("mass", 1.0, written), node.child("inertia", written)
        pose = HERE if written is None else node.pose_in(written)[0]
        entries = [node.number(tag, float(tag[1] == tag[2]), inertia) for tag in parts.INERTIA]
    xx, xy, xz, yy, yz, zz = entries
    inertial = Inertial(mass, origin(composed(moved, pose)), (xx, xy, xz, yy, yz, zz))
    return Link(node.name, inertial, tuple(geometries), node.line())


def _placed(element: Element, node: Node, frames: Frames) -> Pose:
    """Return the pose of a shape in its link."""
    pose, base = node.pose_in(element)
    if not base:
        return pose
    return composed(relative(frames.poses[node], frames.poses[frames.find(base, node)]), pose)


def _shape(element: Element, node: Node, frames: Frames) -> Geometry | None:
    """Return a shape at the origin; None of what is no shape here, which is counted."""
    kind = cast("Kind", element.tag)
    for child in node.text.strict.needed_child(element, "geometry", node.owner).children:
        if child.tag in parts.SIZES:
            size: tuple[float, ...] = ()
            for tag in parts.SIZES[child.tag]:
                written = node.text.strict.needed_child(child, tag, node.owner)
                size += node.numbers(written, 3 if tag == "size" else 1)
            return Geometry(kind, Origin(), cast("parts.Shape", child.tag), size, line=node.line(element))
        if child.tag == "mesh" and child.find("submesh") is None:
            uri, scale = node.said("uri", None, child), node.child("scale", child)
            factors = (1.0, 1.0, 1.0) if scale is None else cast("Vector", node.numbers(scale, 3))
            if package_of(uri) is None and "://" not in uri and node.text.folder:
                uri = f"{node.text.folder}/{uri}"
            return Geometry(kind, Origin(), "mesh", (), uri, factors, node.line(element))
        if child.tag != "empty":
            frames.left[f"<{child.tag}> of a {kind}"] += 1
    return None


def _weighed(
    inertial: Element, node: Node, frames: Frames, collisions: Sequence[tuple[Element, Pose]]
) -> MassProperties:
    """Return the body of a link's collisions, each of its density or that of the link, in the link's frame."""
    usual, bodies = node.number("density", WATER, inertial), []
    for collision, pose in collisions:
        shape, density = _shape(collision, node, frames), node.number("density", usual, collision)
        path = None if shape is None or shape.filename is None else frames.search.find(shape.filename)
        try:
            if not density > 0.0 or shape is None or (shape.filename is not None and path is None):
                raise InputError(f"is of a shape that is not known or not found, or of the density {density:g} kg/m^3")
            if path is None:
                body = SHAPES[shape.shape](*shape.size, density=density)
            else:
                mesh = load_triangles(path)
                body = mass_properties(mesh, scale=shape.scale, symmetry=False, tessellation=False).body
                body = body.scaled_to_mass(body.mass * density / WATER)
        except RobodynError as error:
            what, remedy = f"a <collision> of {node.owner} gives no mass: {error.what}", "write <mass> and <inertia>"
            raise node.error(what, error.remedy or remedy, collision) from None
        bodies.append((body, pose))
    if not bodies:
        what = f'{node.owner} has <inertial auto="true"> and no <collision>'
        raise node.error(what, "add one, or write the mass", inertial)
    body = composite(bodies)
    mass = node.number("mass", body.mass, inertial)
    return body if mass == body.mass else body.scaled_to_mass(mass)


def origin(pose: Pose) -> Origin:
    return Origin(vector(pose[1]), rpy_from_rotation(pose[0]))


def vector(values: Floats) -> Vector:
    x, y, z = (float(value) + 0.0 for value in values)
    return x, y, z
