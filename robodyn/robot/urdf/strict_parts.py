"""Links and joints, strictly: the values of their views."""

from __future__ import annotations

from math import hypot
from typing import cast

from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.parts import (
    JOINT_TYPES,
    SHAPES,
    WITH_AXIS,
    WITH_RANGE,
    Geometry,
    Inertial,
    Joint,
    Kind,
    Limit,
    Link,
    Mimic,
    Shape,
    Vector,
)
from robodyn.robot.urdf.strict import Strict
from robodyn.robot.urdf.view import GeometryView, InertialView, JointView, LinkView
from robodyn.support.wording import alternatives, shown

_UNIT_SCALE: Vector = (1.0, 1.0, 1.0)
_DEFAULT_AXIS: Vector = (1.0, 0.0, 0.0)
_UNIT_TOLERANCE = 1e-6


def strict_link(link: LinkView, strict: Strict) -> Link:
    name = strict.text(link.element, "name", "<link>")
    owner = f"link {shown(name)}"
    strict.child(link.element, "inertial", owner)
    inertial = None if link.inertial is None else _inertial(link.inertial, owner, strict)
    if inertial is None:
        strict.default(link.element.line, f"{owner} has no <inertial>: no mass")
    geometries = tuple(_geometry(geometry, owner, strict) for geometry in link.geometries)
    return Link(name, inertial, geometries, link.element.line)


def _inertial(inertial: InertialView, owner: str, strict: Strict) -> Inertial:
    strict.needed_child(inertial.element, "mass", owner)
    mass = strict.number(inertial.mass, owner)
    if mass < 0:
        strict.warn(inertial.element.line, f"{owner} has a negative mass: {mass:g} kg")
    strict.needed_child(inertial.element, "inertia", owner)
    ixx, ixy, ixz, iyy, iyz, izz = (strict.number(entry, owner) for entry in inertial.entries)
    return Inertial(mass, strict.origin(inertial, owner), (ixx, ixy, ixz, iyy, iyz, izz))


def _geometry(view: GeometryView, owner: str, strict: Strict) -> Geometry:
    shape = _shape(view, owner, strict)
    filename, scale = None, _UNIT_SCALE
    if shape.tag == "mesh":
        scale = cast("Vector", strict.given(view.scale, owner) or _UNIT_SCALE)
        filename = strict.text(shape, "filename", owner)
    return Geometry(
        cast("Kind", view.kind),
        strict.origin(view, owner),
        cast("Shape", shape.tag),
        _size(view, shape, owner, strict),
        filename,
        scale,
        view.element.line,
    )


def _shape(view: GeometryView, owner: str, strict: Strict) -> Element:
    """Return the one shape."""
    geometry = strict.needed_child(view.element, "geometry", owner)
    shapes = [child for child in geometry.children if child.tag in SHAPES]
    if len(shapes) == 1:
        return shapes[0]
    where = f"<geometry> in a <{view.kind}> of {owner}"
    if shapes:
        raise strict.error(shapes[1].line, f"{where} has {len(shapes)} shapes", "keep one of them")
    if not geometry.children:
        raise strict.error(geometry.line, f"{where} has no shape", f"shapes: {', '.join(SHAPES)}")
    tag = geometry.children[0].tag
    remedy = alternatives(tag, SHAPES, "shapes")
    raise strict.error(geometry.line, f"{where} has the unknown shape {shown(tag)}", remedy)


def _size(view: GeometryView, shape: Element, owner: str, strict: Strict) -> tuple[float, ...]:
    size = tuple(length for read in view.sizes for length in strict.numbers(read, owner))
    if any(length <= 0 for length in size):
        strict.warn(shape.line, f"<{shape.tag}> of {owner} has a length that is not positive: {min(size):g} m")
    return size


def strict_joint(joint: JointView, strict: Strict) -> Joint:
    element = joint.element
    name = strict.text(element, "name", "<joint>")
    owner = f"joint {shown(name)}"
    kind = strict.text(element, "type", owner)
    if kind not in JOINT_TYPES:
        remedy = alternatives(kind.lower(), JOINT_TYPES, "types")
        raise strict.error(element.line, f"{owner} has the unknown type {shown(kind)}", remedy)
    parent = strict.text(strict.needed_child(element, "parent", owner), "link", owner)
    child = strict.text(strict.needed_child(element, "child", owner), "link", owner)
    damping, friction = _dynamics(joint, owner, strict)
    return Joint(
        name=name,
        type=kind,
        parent=parent,
        child=child,
        origin=strict.origin(joint, owner),
        axis=_axis(joint, owner, strict),
        limit=_limit(joint, owner, strict),
        damping=damping,
        friction=friction,
        mimic=_mimic(joint, owner, strict),
        line=element.line,
    )


def _axis(joint: JointView, owner: str, strict: Strict) -> Vector:
    """Return the axis as written. Only the types that move along or about it need it to be a direction."""
    written = strict.child(joint.element, "axis", owner)
    if written is None:
        if joint.type in WITH_AXIS:
            strict.default(joint.element.line, f"{owner} has no <axis>: 1 0 0")
        return _DEFAULT_AXIS
    axis = strict.vector(joint.axis, owner)
    length = hypot(*axis)
    if joint.type not in WITH_AXIS or abs(length - 1) <= _UNIT_TOLERANCE:
        return axis
    if length == 0:
        what = f"the axis of {owner} has the length 0, which gives no direction"
        raise strict.error(written.line, what, 'write a direction, for example xyz="0 0 1"')
    strict.warn(written.line, f"the axis of {owner} has the length {length:.9g}, not 1")
    return axis


def _limit(joint: JointView, owner: str, strict: Strict) -> Limit | None:
    strict.child(joint.element, "limit", owner)
    view, ranged = joint.limit, joint.type in WITH_RANGE
    if view is None:
        if ranged:
            strict.default(joint.element.line, f"{owner} has no <limit>: unlimited")
        return None
    line, values = view.element.line, {}
    for read in (view.lower, view.upper, view.effort, view.velocity):
        given = strict.given(read, owner)
        values[read.attribute] = None if given is None else given[0]
    limit = Limit(**values)
    absent = [name for name in values if values[name] is None and (ranged or name in ("effort", "velocity"))]
    if absent:
        strict.default(line, f"<limit> of {owner} has no {', '.join(absent)}: unlimited")
    if limit.lower is not None and limit.upper is not None and limit.lower > limit.upper:
        strict.warn(line, f"<limit> of {owner} is empty: lower {limit.lower:g} > upper {limit.upper:g}")
    for name, value in (("effort", limit.effort), ("velocity", limit.velocity)):
        if value is not None and value < 0:
            strict.warn(line, f"<limit> of {owner} has a negative {name}: {value:g}")
    return limit


def _dynamics(joint: JointView, owner: str, strict: Strict) -> tuple[float, float]:
    written = strict.child(joint.element, "dynamics", owner)
    if written is None:
        return 0.0, 0.0
    damping = strict.number(joint.damping, owner, 0.0)
    friction = strict.number(joint.friction, owner, 0.0)
    for name, value in (("damping", damping), ("friction", friction)):
        if value < 0:
            strict.warn(written.line, f"<dynamics> of {owner} has a negative {name}: {value:g}, which feeds energy in")
    return damping, friction


def _mimic(joint: JointView, owner: str, strict: Strict) -> Mimic | None:
    strict.child(joint.element, "mimic", owner)
    view = joint.mimic
    if view is None:
        return None
    return Mimic(
        strict.text(view.element, "joint", owner),
        strict.number(view.multiplier, owner, 1.0),
        strict.number(view.offset, owner, 0.0),
    )
