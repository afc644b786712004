"""The strict reading of a URDF: what it says, in SI units, with every default on record."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace

from robodyn.robot.urdf.document import Document, read_document
from robodyn.robot.urdf.fields import Fields
from robodyn.robot.urdf.joints import read_joint
from robodyn.robot.urdf.links import read_link
from robodyn.robot.urdf.packages import Search
from robodyn.robot.urdf.parts import Description
from robodyn.robot.urdf.sources import content_of
from robodyn.robot.urdf.structure import by_name, check_mimics, root_link
from robodyn.robot.urdf.transmissions import read_transmission


def load_description(
    source: str | os.PathLike[str] | bytes,
    name: str | None = None,
    *,
    package_paths: Sequence[str | os.PathLike[str]] = (),
    xacro_args: Mapping[str, str] | None = None,
) -> Description:
    """Return `read_description` of `read_document`, with the errors of both; a xacro file is expanded first.

    Args:
        package_paths: packages, or folders of packages, that are looked at before others; see `Search.packages`.
        xacro_args: values of the arguments of a xacro file.
    """
    folders = tuple(os.fspath(path) for path in package_paths)
    file, data = content_of(source, name, folders, xacro_args)
    return replace(read_description(read_document(data, file)), search=Search(file, folders), data=data)


def read_description(document: Document) -> Description:
    """Return links, joints and transmissions of a document, checked to be one tree.

    Method: one pass over the elements and one over the joints; linear in the size of the file, no recursion.

    Args:
        document: elements with their places.

    Returns:
        The description, in the order of the file, lengths in metres, angles in radians, masses in kilograms. Each
        default that was taken and each doubt (negative mass, axis that is no unit vector, ...) is one of its notes.

    Raises:
        DescriptionError: a name is missing, duplicate or refers to nothing; a number is missing, not finite or not a
            number; an axis is zero; links make no tree; a joint mimics itself. With the line.
    """
    robot, fields = document.root, Fields(document.file)
    name = fields.name(robot, "name", "<robot>")
    links = by_name((read_link(element, fields) for element in robot.findall("link")), "link", fields)
    joint_elements = robot.findall("joint")
    joints = by_name((read_joint(element, fields) for element in joint_elements), "joint", fields)
    root = root_link(links, tuple(joints.values()), fields)
    check_mimics(joints, {e.values["name"]: m.line for e in joint_elements if (m := e.find("mimic"))}, fields)
    transmissions = (read_transmission(element, joints, fields) for element in robot.findall("transmission"))
    driven = tuple(transmission for transmission in transmissions if transmission is not None)
    notes = tuple(sorted(fields.notes, key=lambda note: note.line))
    parts = tuple(links.values()), tuple(joints.values()), driven
    return Description(name, document.file, *parts, root, notes, Search(document.file))
