"""The strict reading of a URDF: what it says, in SI units."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

from robodyn.robot.urdf.document import Document, read_document
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import TEXT, Numbers, numbers
from robodyn.robot.urdf.packages import Search
from robodyn.robot.urdf.parts import Description, Transmission
from robodyn.robot.urdf.sources import content_of
from robodyn.robot.urdf.strict import Strict
from robodyn.robot.urdf.structure import by_name, check_mimics, root_link
from robodyn.robot.urdf.view import JointView, LinkView, View
from robodyn.support.wording import shown

_REDUCTIONS = ("mechanicalReduction", "mechanical_reduction", "drake:gear_ratio")
_ROTOR_INERTIAS = ("rotorInertia", "rotor_inertia", "motorInertia", "motor_inertia", "drake:rotor_inertia")


def load_description(
    source: str | os.PathLike[str] | bytes,
    name: str | None = None,
    *,
    package_paths: Sequence[str | os.PathLike[str]] = (),
    xacro_args: Mapping[str, str] | None = None,
    trust_xacro: bool = False,
) -> Description:
    """Return `read_description` of `read_document`, with the errors of both; a xacro file is expanded first.

    Args:
        package_paths: packages, or folders of packages, that are looked at before others; see `Search.packages`.
        xacro_args: values of the arguments of a xacro file.
        trust_xacro: let it run any Python, read any file and all of the environment.
    """
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
    values = [strict.number(_number(element), owner) for element in found]
    for element, value in zip(found, values, strict=True):
        if value != values[0]:
            what = f"{owner} contradicts itself: <{found[0].tag}> {values[0]:g} in line {found[0].line}, then {value:g}"
            raise strict.error(element.line, what, "keep one of them")
    return values[0] if values else None


def _number(element: Element) -> Numbers:
    """Return the number in the element's text, or in its attribute `value`, as Drake writes it."""
    return numbers(element, TEXT if element.get("value") is None else "value", 1)
