"""The strict reading of a URDF: what it says, in SI units, checked to be one tree; and the shapes of its links."""

from __future__ import annotations

import os
from collections.abc import Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TypeVar

from robodyn.errors import DescriptionError, InputError
from robodyn.robot.urdf.document import Document, read_document
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import TEXT, numbers
from robodyn.robot.urdf.packages import Search, package_of
from robodyn.robot.urdf.parts import Description, Geometry, Joint, Kind, Link, Transmission
from robodyn.robot.urdf.sources import content_of
from robodyn.robot.urdf.strict import Strict
from robodyn.robot.urdf.view import JointView, LinkView, View
from robodyn.support.wording import alternatives, listed, shown

_REDUCTIONS = ("mechanicalReduction", "mechanical_reduction", "drake:gear_ratio")
_ROTOR_INERTIAS = ("rotorInertia", "rotor_inertia", "motorInertia", "motor_inertia", "drake:rotor_inertia")
_MOST_SHOWN = 6
"""Names of a cycle."""

N = TypeVar("N", Link, Joint)
K = TypeVar("K", bound=Hashable)


def load_description(
    source: str | os.PathLike[str] | bytes,
    name: str | None = None,
    *,
    package_paths: Sequence[str | os.PathLike[str]] = (),
    xacro_args: Mapping[str, str] | None = None,
    trust_xacro: bool = False,
) -> Description:
    """Return `read_description` of `read_document`, with the errors of both; options as of `robodyn.load`."""
    folders = tuple(os.fspath(path) for path in package_paths)
    file, data = content_of(source, name, folders, xacro_args, trust_xacro)
    return replace(read_description(read_document(data, file)), search=Search(file, folders), data=data)


def read_description(document: Document, view: View | None = None) -> Description:
    """Return links, joints and transmissions of a document, checked to be one tree.

    Method: the values of a view of the document, of whose faults the first is raised; linear in the size of the file,
    no recursion.

    Args:
        document: elements with their places.
        view: of the document, where there is one; otherwise each part of it is dropped as soon as its values are taken.

    Returns:
        The description, in the order of the file, lengths in metres, angles in radians, masses in kilograms. Each
        doubt (negative mass, axis that is no unit vector, ...) is one of its notes.

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
    transmissions = (_transmission(element, joints, strict) for element in robot.findall("transmission"))
    driven = tuple(transmission for transmission in transmissions if transmission is not None)
    notes = tuple(sorted(strict.notes, key=lambda note: note[0]))
    parts = tuple(links.values()), tuple(joints.values()), driven
    return Description(name, document.file, *parts, root, notes, Search(document.file))


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
    """Return the one value that the actuator, the joint or the transmission gives."""
    found = [child for place in places for child in place.children if child.tag in tags]
    texts = [TEXT if element.get("value") is None else "value" for element in found]  # as Drake writes it
    values = [strict.number(numbers(*each, 1), owner) for each in zip(found, texts, strict=True)]
    for element, value in zip(found, values, strict=True):
        if value != values[0]:
            what = f"{owner} contradicts itself: <{found[0].tag}> {values[0]:g} in line {found[0].line}, then {value:g}"
            raise strict.error(element.line, what, "keep one of them")
    return values[0] if values else None


def by_name(parts: Iterable[N], kind: str, strict: Strict) -> dict[str, N]:
    """Return the parts by name; no name may stand for two."""
    named: dict[str, N] = {}
    for part in parts:
        first = named.setdefault(part.name, part)
        if first is not part:
            what = f"a second {kind} {shown(part.name)}, the first is in line {first.line}"
            raise strict.error(part.line, what, "rename one of them")
    return named


def root_link(links: Mapping[str, Link], joints: Sequence[Joint], strict: Strict) -> str:
    """Return the name of the one link without a parent, after checking that the joints make a tree of the links."""
    if not links:
        raise strict.error(1, "the robot has no links", "add a <link>")
    above = _joint_above(links, joints, strict)
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


def _joint_above(links: Mapping[str, Link], joints: Iterable[Joint], strict: Strict) -> dict[str, Joint]:
    """Return for each link but the roots the joint that it is a child of."""
    above: dict[str, Joint] = {}
    for joint in joints:
        for role, link in (("parent", joint.parent), ("child", joint.child)):
            if link not in links:
                what = f"the {role} of joint {shown(joint.name)} is link {shown(link)}, which does not exist"
                raise strict.error(joint.line, what, alternatives(link, links, "links"))
        first = above.setdefault(joint.child, joint)
        if first is not joint:
            what = f"link {shown(joint.child)} is a child of two joints: {shown(first.name)} (line {first.line})"
            raise strict.error(joint.line, f"{what} and {shown(joint.name)}", "a link has one parent; remove one joint")
    return above


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
    names = [shown(name) for name in islice(cycle, _MOST_SHOWN)]
    if len(cycle) > _MOST_SHOWN:
        names.append(f"... ({len(cycle)} in all)")
    return " -> ".join([*names, names[0]])


@dataclass(frozen=True, slots=True)
class Shape:
    """A shape of a link.

    Attributes:
        geometry: as described: kind, pose, sizes, file name, scale, and the line.
        path: the file of a mesh; None where it is not found, and of other shapes.
    """

    geometry: Geometry
    path: Path | None = None

    @property
    def missing(self) -> bool:
        """Whether this is a mesh without a file."""
        return self.geometry.filename is not None and self.path is None


def link_named(description: Description, name: str) -> Link:
    """Return the link of this name; InputError if there is none."""
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
