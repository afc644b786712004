"""Strict reading: the values of a view, of whose faults the first is raised; doubts are noted, defaults are taken."""

from __future__ import annotations

from math import hypot
from typing import NoReturn, cast

from robodyn.errors import DescriptionError
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import TEXT, Numbers
from robodyn.robot.urdf.parts import (
    JOINT_TYPES,
    SHAPES,
    WITH_AXIS,
    ZERO,
    Geometry,
    Inertial,
    Joint,
    Kind,
    Limit,
    Link,
    Mimic,
    Origin,
    Shape,
    Vector,
)
from robodyn.robot.urdf.view import GeometryView, InertialView, JointView, LinkView, Part
from robodyn.support.wording import alternatives, shown

_UNIT_SCALE: Vector = (1.0, 1.0, 1.0)
_DEFAULT_AXIS: Vector = (1.0, 0.0, 0.0)
_UNIT_TOLERANCE = 1e-6


class Strict:
    """Values out of a view of one file. `owner` is the part of the robot that messages name.

    Attributes:
        notes: doubts, each with its line.
    """

    def __init__(self, file: str) -> None:
        self.file = file
        self.notes: list[tuple[int, str]] = []

    def error(self, line: int, what: str, remedy: str) -> DescriptionError:
        return DescriptionError(what, remedy=remedy, file=self.file, line=line)

    def doubt(self, line: int, what: str) -> None:
        self.notes.append((line, what))

    def child(self, element: Element, tag: str, owner: str) -> Element | None:
        """Return the child with that tag, of which there may be one at most."""
        children = [child for child in element.children if child.tag == tag]
        if len(children) > 1:
            what = f"{_where(element, owner)} has {len(children)} <{tag}> elements"
            raise self.error(children[1].line, what, "keep one of them")
        return children[0] if children else None

    def needed_child(self, element: Element, tag: str, owner: str) -> Element:
        child = self.child(element, tag, owner)
        if child is None:
            raise self.error(element.line, f"{_where(element, owner)} has no <{tag}>", f"add <{tag} .../>")
        return child

    def text(self, element: Element, attribute: str, owner: str) -> str:
        """Return an attribute that must be there and not be empty."""
        return element.get(attribute) or self._missing(element, attribute, owner)

    def given(self, read: Numbers, owner: str) -> tuple[float, ...] | None:
        """Return the numbers of an attribute, None where it is absent."""
        if read.problem is not None:
            assert read.element is not None, "it has the attribute"
            line, what = read.element.line, f"<{read.element.tag}> of {owner} {read.problem}"
            if read.attribute != TEXT:
                line, what = read.element.attributes[read.attribute].span.line, f"'{read.attribute}' in {what}"
            raise self.error(line, what, read.problem.remedy)
        return read.values

    def numbers(self, read: Numbers, owner: str, *default: float) -> tuple[float, ...]:
        """Return the numbers of an attribute; where it is absent the default, if there is one."""
        numbers = read.values or self.given(read, owner) or default
        if not numbers:
            assert read.element is not None, "its element is there"
            self._missing(read.element, read.attribute, owner)
        return numbers

    def number(self, read: Numbers, owner: str, *default: float) -> float:
        return self.numbers(read, owner, *default)[0]

    def vector(self, read: Numbers, owner: str, *default: float) -> Vector:
        return cast("Vector", self.numbers(read, owner, *default))

    def origin(self, part: Part, owner: str) -> Origin:
        """Return the pose of a part; zero where it says nothing."""
        self.child(part.element, "origin", owner)
        return Origin(self.vector(part.origin.xyz, owner, *ZERO), self.vector(part.origin.rpy, owner, *ZERO))

    def _missing(self, element: Element, attribute: str, owner: str) -> NoReturn:
        state = "no" if element.get(attribute) is None else "an empty"
        what = f"{_where(element, owner)} has {state} attribute '{attribute}'"
        raise self.error(element.line, what, f'write {attribute}="..."')

    def link(self, link: LinkView) -> Link:
        name = self.text(link.element, "name", "<link>")
        owner = f"link {shown(name)}"
        self.child(link.element, "inertial", owner)
        inertial = None if link.inertial is None else self._inertial(link.inertial, owner)
        geometries = tuple(self._geometry(geometry, owner) for geometry in link.geometries)
        return Link(name, inertial, geometries, link.element.line)

    def _inertial(self, inertial: InertialView, owner: str) -> Inertial:
        self.needed_child(inertial.element, "mass", owner)
        mass = self.number(inertial.mass, owner)
        if mass < 0:
            self.doubt(inertial.element.line, f"{owner} has a negative mass: {mass:g} kg")
        self.needed_child(inertial.element, "inertia", owner)
        ixx, ixy, ixz, iyy, iyz, izz = (self.number(entry, owner) for entry in inertial.entries)
        return Inertial(mass, self.origin(inertial, owner), (ixx, ixy, ixz, iyy, iyz, izz))

    def _geometry(self, view: GeometryView, owner: str) -> Geometry:
        shape = self._shape(view, owner)
        filename, scale = None, _UNIT_SCALE
        if shape.tag == "mesh":
            scale = cast("Vector", self.given(view.scale, owner) or _UNIT_SCALE)
            filename = self.text(shape, "filename", owner)
        size = tuple(length for read in view.sizes for length in self.numbers(read, owner))
        if any(length <= 0 for length in size):
            self.doubt(shape.line, f"<{shape.tag}> of {owner} has a length that is not positive: {min(size):g} m")
        kind, origin = cast("Kind", view.kind), self.origin(view, owner)
        return Geometry(kind, origin, cast("Shape", shape.tag), size, filename, scale, view.element.line)

    def _shape(self, view: GeometryView, owner: str) -> Element:
        """Return the one shape."""
        geometry = self.needed_child(view.element, "geometry", owner)
        shapes = [child for child in geometry.children if child.tag in SHAPES]
        if len(shapes) == 1:
            return shapes[0]
        where = f"<geometry> in a <{view.kind}> of {owner}"
        if shapes:
            raise self.error(shapes[1].line, f"{where} has {len(shapes)} shapes", "keep one of them")
        if not geometry.children:
            raise self.error(geometry.line, f"{where} has no shape", f"shapes: {', '.join(SHAPES)}")
        tag = geometry.children[0].tag
        remedy = alternatives(tag, SHAPES, "shapes")
        raise self.error(geometry.line, f"{where} has the unknown shape {shown(tag)}", remedy)

    def joint(self, joint: JointView) -> Joint:
        element = joint.element
        name = self.text(element, "name", "<joint>")
        owner = f"joint {shown(name)}"
        kind = self.text(element, "type", owner)
        if kind not in JOINT_TYPES:
            remedy = alternatives(kind.lower(), JOINT_TYPES, "types")
            raise self.error(element.line, f"{owner} has the unknown type {shown(kind)}", remedy)
        parent, child = (self.text(self.needed_child(element, role, owner), "link", owner) for role in _ENDS)
        dynamics, mimic = self.child(element, "dynamics", owner), joint.mimic
        damping, friction = (self.number(read, owner, 0.0) for read in (joint.damping, joint.friction))
        for quantity, value in (("damping", damping), ("friction", friction)):
            if dynamics is not None and value < 0:
                what = f"<dynamics> of {owner} has a negative {quantity}: {value:g}, which feeds energy in"
                self.doubt(dynamics.line, what)
        origin, axis, limit = self.origin(joint, owner), self._axis(joint, owner), self._limit(joint, owner)
        self.child(element, "mimic", owner)
        leader = None
        if mimic is not None:
            multiplier, offset = self.number(mimic.multiplier, owner, 1.0), self.number(mimic.offset, owner, 0.0)
            leader = Mimic(self.text(mimic.element, "joint", owner), multiplier, offset)
        return Joint(name, kind, parent, child, origin, axis, limit, damping, friction, leader, element.line)

    def _axis(self, joint: JointView, owner: str) -> Vector:
        """Return the axis as written. Only the types that move along or about it need it to be a direction."""
        written = self.child(joint.element, "axis", owner)
        if written is None:
            return _DEFAULT_AXIS
        axis = self.vector(joint.axis, owner)
        length = hypot(*axis)
        if joint.type not in WITH_AXIS or abs(length - 1) <= _UNIT_TOLERANCE:
            return axis
        if length == 0:
            what = f"the axis of {owner} has the length 0, which gives no direction"
            raise self.error(written.line, what, 'write a direction, for example xyz="0 0 1"')
        self.doubt(written.line, f"the axis of {owner} has the length {length:.9g}, not 1")
        return axis

    def _limit(self, joint: JointView, owner: str) -> Limit | None:
        written, view = self.child(joint.element, "limit", owner), joint.limit
        if written is None or view is None:
            return None
        reads = (view.lower, view.upper, view.effort, view.velocity)
        limit = Limit(*(None if (given := self.given(read, owner)) is None else given[0] for read in reads))
        if limit.lower is not None and limit.upper is not None and limit.lower > limit.upper:
            self.doubt(written.line, f"<limit> of {owner} is empty: lower {limit.lower:g} > upper {limit.upper:g}")
        for name, value in (("effort", limit.effort), ("velocity", limit.velocity)):
            if value is not None and value < 0:
                self.doubt(written.line, f"<limit> of {owner} has a negative {name}: {value:g}")
        return limit


_ENDS = ("parent", "child")


def _where(element: Element, owner: str) -> str:
    """Return `owner` where the element is the owner itself, otherwise `<tag> of owner`."""
    return owner if owner.partition(" ")[0].strip("<>") == element.tag else f"<{element.tag}> of {owner}"
