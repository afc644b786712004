"""<link>: mass, inertia and shapes."""

from __future__ import annotations

from typing import Literal, cast

from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.fields import Fields
from robodyn.robot.urdf.parts import INERTIA, SHAPES, SIZES, Geometry, Inertial, Link, Vector
from robodyn.support.wording import alternatives, shown

_UNIT: Vector = (1.0, 1.0, 1.0)
Shape = Literal["box", "cylinder", "sphere", "capsule", "mesh"]


def read_link(element: Element, fields: Fields) -> Link:
    name = fields.name(element, "name", "<link>")
    owner = f"link {shown(name)}"
    written = fields.child(element, "inertial", owner)
    inertial = None if written is None else _inertial(written, owner, fields)
    if inertial is None:
        fields.default(element.line, f"{owner} has no <inertial>: no mass")
    geometries = tuple(
        _geometry(child, owner, fields) for child in element.children if child.tag in ("visual", "collision")
    )
    return Link(name, inertial, geometries, element.line)


def _inertial(element: Element, owner: str, fields: Fields) -> Inertial:
    mass = fields.needed_number(fields.needed_child(element, "mass", owner), "value", owner)
    if mass < 0:
        fields.warn(element.line, f"{owner} has a negative mass: {mass:g} kg")
    inertia = fields.needed_child(element, "inertia", owner)
    ixx, ixy, ixz, iyy, iyz, izz = (fields.needed_number(inertia, name, owner) for name in INERTIA)
    return Inertial(mass, fields.origin(element, owner), (ixx, ixy, ixz, iyy, iyz, izz))


def _geometry(element: Element, owner: str, fields: Fields) -> Geometry:
    geometry = fields.needed_child(element, "geometry", owner)
    shapes = [child for child in geometry.children if child.tag in SHAPES]
    if len(shapes) != 1:
        raise _no_single_shape(geometry, shapes, f"<geometry> in a <{element.tag}> of {owner}", fields)
    shape = shapes[0]
    filename, scale = _mesh(shape, owner, fields) if shape.tag == "mesh" else (None, _UNIT)
    return Geometry(
        cast('Literal["visual", "collision"]', element.tag),
        fields.origin(element, owner),
        cast("Shape", shape.tag),
        _size(shape, owner, fields),
        filename,
        scale,
        element.line,
    )


def _no_single_shape(geometry: Element, shapes: list[Element], where: str, fields: Fields) -> Exception:
    if shapes:
        return fields.error(shapes[1].line, f"{where} has {len(shapes)} shapes", "keep one of them")
    if not geometry.children:
        return fields.error(geometry.line, f"{where} has no shape", f"shapes: {', '.join(SHAPES)}")
    tag = geometry.children[0].tag
    return fields.error(
        geometry.line, f"{where} has the unknown shape {shown(tag)}", alternatives(tag, SHAPES, "shapes")
    )


def _size(shape: Element, owner: str, fields: Fields) -> tuple[float, ...]:
    size: tuple[float, ...] = ()
    for attribute in SIZES.get(shape.tag, ()):
        numbers = fields.numbers(shape, attribute, 3 if attribute == "size" else 1, owner)
        if numbers is None:
            raise fields.missing(shape, attribute, owner)
        size += numbers
    if any(length <= 0 for length in size):
        fields.warn(shape.line, f"<{shape.tag}> of {owner} has a length that is not positive: {min(size):g} m")
    return size


def _mesh(shape: Element, owner: str, fields: Fields) -> tuple[str, Vector]:
    scale = fields.vector(shape, "scale", owner)
    return fields.name(shape, "filename", owner), _UNIT if scale is None else scale
