"""The strict reading of a URDF: what it says, in SI units, checked to be one tree; and the shapes of its links.

`Strict` takes its values out of a view of the document, and raises the first fault; doubts are noted.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import hypot
from pathlib import Path
from typing import NoReturn, TypeVar, cast

from robodyn.errors import DescriptionError, InputError
from robodyn.robot.urdf import parts
from robodyn.robot.urdf.document import Document, Element, read_document
from robodyn.robot.urdf.parts import Description, Geometry, Joint, Kind, Link, Transmission, Vector
from robodyn.robot.urdf.sources import Search, package_of
from robodyn.robot.urdf.view import TEXT, GeometryView, InertialView, JointView, LinkView, Numbers, Part, View, numbers
from robodyn.support.wording import alternatives, listed, shown

_REDUCTIONS = ("mechanicalReduction", "mechanical_reduction", "drake:gear_ratio")
_ROTOR_INERTIAS = ("rotorInertia", "rotor_inertia", "motorInertia", "motor_inertia", "drake:rotor_inertia")
_MOST_SHOWN = 6
"""Names of a cycle."""
_UNIT_TOLERANCE = 1e-6

N = TypeVar("N", Link, Joint)
K = TypeVar("K", bound=Hashable)


def read_urdf(data: bytes, file: str, package_paths: tuple[str, ...] = ()) -> Description:
    """Return `read_description` of `read_document`, with what was read and where its meshes are looked for."""
    return replace(read_description(read_document(data, file)), search=Search(file, package_paths), data=data)


def read_description(document: Document, view: View | None = None) -> Description:
    """Return links, joints and transmissions of a document, in the order of the file, checked to be one tree.

    Linear in the size of the file. Each doubt (negative mass, axis that is no unit vector) is a note. Without a view of
    the document each part of one is dropped as soon as its values are taken.

    Raises:
        DescriptionError: a name is missing, duplicate or refers to nothing; a number is missing, not finite or not a
            number; an axis is zero; links make no tree; a joint mimics itself. With the line.
    """
    robot, strict = document.root, Strict(document.file)
    name = strict.text(robot, "name", "<robot>")
    joint_elements = robot.findall("joint")
    link_views: Iterable[LinkView] = map(LinkView, robot.findall("link")) if view is None else view.links
    joint_views: Iterable[JointView] = map(JointView, joint_elements) if view is None else view.joints
    links = by_name(map(strict.link, link_views), "link", strict)
    joints = by_name(map(strict.joint, joint_views), "joint", strict)
    root = root_link(links, tuple(joints.values()), strict)
    check_mimics(joints, {e.values["name"]: m.line for e in joint_elements if (m := e.find("mimic"))}, strict)
    driven = tuple(filter(None, (_transmission(each, joints, strict) for each in robot.findall("transmission"))))
    notes = tuple(sorted(strict.notes, key=lambda note: note[0]))
    return Description(
        name, document.file, tuple(links.values()), tuple(joints.values()), driven, root, notes, Search(document.file)
    )


class Strict:
    """Values out of a view of one file, with doubts as notes. `owner` is the part of the robot that messages name."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.notes: list[tuple[int, str]] = []

    def error(self, line: int, what: str, remedy: str) -> DescriptionError:
        return DescriptionError(what, remedy=remedy, file=self.file, line=line)

    def doubt(self, line: int, what: str) -> None:
        self.notes.append((line, what))

    def child(self, element: Element, tag: str, owner: str) -> Element | None:
        """Return the child with that tag, of which there may be one at most."""
        children = element.findall(tag)
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
        return element.get(attribute) or self._missing(element, attribute, owner)

    def _missing(self, element: Element, attribute: str, owner: str) -> NoReturn:
        state = "no" if element.get(attribute) is None else "an empty"
        what = f"{_where(element, owner)} has {state} attribute '{attribute}'"
        raise self.error(element.line, what, f'write {attribute}="..."')

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

    def origin(self, part: Part, owner: str) -> parts.Origin:
        self.child(part.element, "origin", owner)
        xyz, rpy = (self.vector(read, owner, *parts.ZERO) for read in (part.origin.xyz, part.origin.rpy))
        return parts.Origin(xyz, rpy)

    def link(self, link: LinkView) -> Link:
        name = self.text(link.element, "name", "<link>")
        owner = f"link {shown(name)}"
        self.child(link.element, "inertial", owner)
        inertial = None if link.inertial is None else self._inertial(link.inertial, owner)
        geometries = tuple(self._geometry(geometry, owner) for geometry in link.geometries)
        return Link(name, inertial, geometries, link.element.line)

    def _inertial(self, inertial: InertialView, owner: str) -> parts.Inertial:
        self.needed_child(inertial.element, "mass", owner)
        mass = self.number(inertial.mass, owner)
        if mass < 0:
            self.doubt(inertial.element.line, f"{owner} has a negative mass: {mass:g} kg")
        self.needed_child(inertial.element, "inertia", owner)
        ixx, ixy, ixz, iyy, iyz, izz = (self.number(entry, owner) for entry in inertial.entries)
        return parts.Inertial(mass, self.origin(inertial, owner), (ixx, ixy, ixz, iyy, iyz, izz))

    def _geometry(self, view: GeometryView, owner: str) -> Geometry:
        geometry = self.needed_child(view.element, "geometry", owner)
        shapes = [child for child in geometry.children if child.tag in parts.SHAPES]
        where = f"<geometry> in a <{view.kind}> of {owner}"
        if len(shapes) > 1:
            raise self.error(shapes[1].line, f"{where} has {len(shapes)} shapes", "keep one of them")
        if not geometry.children:
            raise self.error(geometry.line, f"{where} has no shape", f"shapes: {', '.join(parts.SHAPES)}")
        if not shapes:
            tag = geometry.children[0].tag
            remedy = alternatives(tag, parts.SHAPES, "shapes")
            raise self.error(geometry.line, f"{where} has the unknown shape {shown(tag)}", remedy)
        shape, line = shapes[0], view.element.line
        kind, tag = cast("Kind", view.kind), cast("parts.Shape", shape.tag)
        if tag == "mesh":
            scale = cast("Vector", self.given(view.scale, owner) or (1.0, 1.0, 1.0))
            filename = self.text(shape, "filename", owner)
            return Geometry(kind, self.origin(view, owner), tag, (), filename, scale, line)
        size = tuple(length for read in view.sizes for length in self.numbers(read, owner))
        if any(length <= 0 for length in size):
            self.doubt(shape.line, f"<{tag}> of {owner} has a length that is not positive: {min(size):g} m")
        return Geometry(kind, self.origin(view, owner), tag, size, line=line)

    def joint(self, joint: JointView) -> Joint:
        element = joint.element
        name = self.text(element, "name", "<joint>")
        owner = f"joint {shown(name)}"
        kind = self.text(element, "type", owner)
        if kind not in parts.JOINT_TYPES:
            remedy = alternatives(kind.lower(), parts.JOINT_TYPES, "types")
            raise self.error(element.line, f"{owner} has the unknown type {shown(kind)}", remedy)
        ends = (self.needed_child(element, role, owner) for role in ("parent", "child"))
        parent, child = (self.text(end, "link", owner) for end in ends)
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
            leader = parts.Mimic(self.text(mimic.element, "joint", owner), multiplier, offset)
        return Joint(name, kind, parent, child, origin, axis, limit, damping, friction, leader, element.line)

    def _axis(self, joint: JointView, owner: str) -> Vector:
        """Return the axis as written. Only the types that move along or about it need it to be a direction."""
        written = self.child(joint.element, "axis", owner)
        if written is None:
            return 1.0, 0.0, 0.0
        axis = self.vector(joint.axis, owner)
        length = hypot(*axis)
        if joint.type not in parts.WITH_AXIS or abs(length - 1) <= _UNIT_TOLERANCE:
            return axis
        if length == 0:
            what = f"the axis of {owner} has the length 0, which gives no direction"
            raise self.error(written.line, what, 'write a direction, for example xyz="0 0 1"')
        self.doubt(written.line, f"the axis of {owner} has the length {length:.9g}, not 1")
        return axis

    def _limit(self, joint: JointView, owner: str) -> parts.Limit | None:
        written, view = self.child(joint.element, "limit", owner), joint.limit
        if written is None or view is None:
            return None
        reads = (view.lower, view.upper, view.effort, view.velocity)
        limit = parts.Limit(*(None if (given := self.given(read, owner)) is None else given[0] for read in reads))
        if limit.lower is not None and limit.upper is not None and limit.lower > limit.upper:
            self.doubt(written.line, f"<limit> of {owner} is empty: lower {limit.lower:g} > upper {limit.upper:g}")
        for name, value in (("effort", limit.effort), ("velocity", limit.velocity)):
            if value is not None and value < 0:
                self.doubt(written.line, f"<limit> of {owner} has a negative {name}: {value:g}")
        return limit


def _where(element: Element, owner: str) -> str:
    return owner if owner.partition(" ")[0].strip("<>") == element.tag else f"<{element.tag}> of {owner}"


def _transmission(element: Element, joints: Collection[str], strict: Strict) -> Transmission | None:
    """Return one motor on one joint; None, with a warning, where no single joint of the robot is driven."""
    name = element.get("name") or ""
    owner = f"transmission {shown(name)}"
    driven, actuators = element.findall("joint"), element.findall("actuator")
    if len(driven) != 1 or len(actuators) > 1:
        counts = f"{len(driven)} <joint> and {len(actuators)} <actuator>"
        strict.doubt(element.line, f"{owner} has {counts} and is left out: only one motor on one joint is understood")
        return None
    joint = driven[0].get("name")
    if joint is None or joint not in joints:
        strict.doubt(driven[0].line, f"{owner} names no joint of the robot and is left out: {shown(joint or '')}")
        return None
    places = (*actuators, *driven, element)
    reduction = _value(places, _REDUCTIONS, owner, strict)
    if reduction == 0:
        strict.doubt(element.line, f"{owner} has the reduction 0: the rotor does not turn with the joint")
    rotor_inertia = _value(places, _ROTOR_INERTIAS, owner, strict)
    return Transmission(name, joint, 1.0 if reduction is None else reduction, rotor_inertia, element.line)


def _value(places: Collection[Element], tags: Collection[str], owner: str, strict: Strict) -> float | None:
    found = [child for place in places for child in place.children if child.tag in tags]
    texts = [TEXT if element.get("value") is None else "value" for element in found]  # as Drake writes it
    values = [strict.number(numbers(*each, 1), owner) for each in zip(found, texts, strict=True)]
    for element, value in zip(found, values, strict=True):
        if value != values[0]:
            what = f"{owner} contradicts itself: <{found[0].tag}> {values[0]:g} in line {found[0].line}, then {value:g}"
            raise strict.error(element.line, what, "keep one of them")
    return values[0] if values else None


def by_name(given: Iterable[N], kind: str, strict: Strict) -> dict[str, N]:
    named: dict[str, N] = {}
    for part in given:
        first = named.setdefault(part.name, part)
        if first is not part:
            what = f"a second {kind} {shown(part.name)}, the first is in line {first.line}"
            raise strict.error(part.line, what, "rename one of them")
    return named


def root_link(links: Mapping[str, Link], joints: Sequence[Joint], strict: Strict) -> str:
    """Return the name of the one link without a parent, after checking that the joints make a tree of the links."""
    if not links:
        raise strict.error(1, "the robot has no links", "add a <link>")
    above: dict[str, Joint] = {}  # the joint that each link but the roots is a child of
    for joint in joints:
        for role, link in (("parent", joint.parent), ("child", joint.child)):
            if link not in links:
                what = f"the {role} of joint {shown(joint.name)} is link {shown(link)}, which does not exist"
                raise strict.error(joint.line, what, alternatives(link, links, "links"))
        other = above.setdefault(joint.child, joint)
        if other is not joint:
            what = f"link {shown(joint.child)} is a child of two joints: {shown(other.name)} (line {other.line})"
            raise strict.error(joint.line, f"{what} and {shown(joint.name)}", "a link has one parent; remove one joint")
    for cycle in cycles({child: joint.parent for child, joint in above.items()}):
        first = min((above[link] for link in cycle), key=lambda joint: joint.line)
        start = cycle.index(first.parent)
        downward = [*cycle[start::-1], *cycle[:start:-1]]
        what = f"links are children of each other in a cycle: {_round(downward)}"
        raise strict.error(first.line, what, "a URDF must be a tree")
    roots = [link for link in links if link not in above]
    if len(roots) > 1:
        what = f"{len(roots)} links have no parent: {listed(roots)}"
        raise strict.error(links[roots[1]].line, what, "join them to one tree; a URDF has one root link")
    return roots[0]


def check_mimics(joints: Mapping[str, Joint], lines: Mapping[str, int], strict: Strict) -> None:
    """Check that mimic joints follow joints that lead somewhere; `lines` are those of the <mimic> elements."""
    leaders = {joint.name: joint.mimic.joint for joint in joints.values() if joint.mimic is not None}
    for name, leader in leaders.items():
        if leader not in joints:
            what = f"joint {shown(name)} mimics joint {shown(leader)}, which does not exist"
            raise strict.error(lines[name], what, alternatives(leader, joints, "joints"))
        if leader == name:
            raise strict.error(lines[name], f"joint {shown(name)} mimics itself", "name another joint")
    for cycle in cycles(leaders):
        what = f"joints mimic each other in a cycle: {_round(cycle)}"
        raise strict.error(min(lines[name] for name in cycle), what, "let one of them be free")


def cycles(successor: Mapping[K, K]) -> Iterator[list[K]]:
    """Yield every cycle of a graph in which each node has at most one successor. Each node is visited twice at most."""
    walk_of: dict[K, int] = {}
    for walk, start in enumerate(successor):
        node = start
        while node in successor and node not in walk_of:
            walk_of[node] = walk
            node = successor[node]
        if walk_of.get(node) == walk:
            cycle = [node]
            while (node := successor[node]) != cycle[0]:
                cycle.append(node)
            yield cycle


def _round(cycle: Sequence[str]) -> str:
    names = [shown(name) for name in cycle[:_MOST_SHOWN]]
    more = [f"... ({len(cycle)} in all)"] if len(cycle) > _MOST_SHOWN else []
    return " -> ".join([*names, *more, names[0]])


@dataclass(frozen=True, slots=True)
class Shape:
    """A shape of a link as described, and the file of a mesh; None where it is not found, and of other shapes."""

    geometry: Geometry
    path: Path | None = None

    @property
    def missing(self) -> bool:
        """Whether this is a mesh without a file."""
        return self.geometry.filename is not None and self.path is None


def link_named(description: Description, name: str) -> Link:
    links = {link.name: link for link in description.links}
    if name not in links:
        remedy = alternatives(name, links, "links")
        raise InputError(f"there is no link {shown(name)}", remedy=remedy, file=description.file)
    return links[name]


def link_shapes(description: Description, link: str, kind: Kind | None = None) -> tuple[Shape, ...]:
    """Return the shapes of a link in the order of the file, of one kind or of both."""
    find = description.search.find
    return tuple(
        Shape(geometry, None if geometry.filename is None else find(geometry.filename))
        for geometry in link_named(description, link).geometries
        if kind is None or geometry.kind == kind
    )


def missing_mesh(description: Description, geometry: Geometry) -> DescriptionError:
    """Return the error of a mesh whose file is not found."""
    name = geometry.filename or ""
    package = package_of(name)
    remedy = "names are relative to the description's folder"
    if package is not None and package[0]:
        remedy = f"--package-path DIR names the package {shown(package[0])} or the folder it is in"
    elif "://" in name and not name.startswith("file://"):
        remedy = "files are not fetched; save it beside the description"
    what = f"the mesh {shown(name)} is not found"
    return DescriptionError(what, remedy=remedy, file=description.file, line=geometry.line)
