"""MJCF and SDF: rules on bodies, joints and shapes, on the URDF that says the same; they find elements of the file."""

from __future__ import annotations

import os
from dataclasses import replace

from robodyn.errors import InputError
from robodyn.robot.urdf.document import Document, read, read_document
from robodyn.robot.urdf.parts import Description
from robodyn.robot.urdf.sources import root_tag
from robodyn.robot.urdf.xacro import Expansion
from robodyn.robot.write.urdf import new_urdf

RULES = (
    *("RD111", "RD112", "RD113", "RD201", "RD204", "RD205", "RD206", "RD207", "RD208", "RD209", "RD21", "RD3", "RD4"),
    *("RD503", "RD507", "RD509", "RD512", "RD515", "RD516", "RD517"),
    *("RD601", "RD602", "RD604", "RD605", "RD606", "RD608", "RD609", "RD61", "RD8"),
)
"""Codes of the rules that ask about the robot: not about the text of a URDF, nor about links without mass, which stand
between several joints of a body."""
_OWN = ".msh"  # meshes of MuJoCo's own, which nothing else reads


def as_urdf(description: Description) -> tuple[Document, Expansion]:
    """Return the URDF of a description, and of each element of it what it comes from: the body, link or joint of the
    file. InputError of what is no file, or UTF-16."""
    file = description.file
    if not os.path.isfile(file):
        raise InputError("MJCF and SDF are checked as files", remedy="name the file", file=file)
    source = read_document(description.data, file, root_tag(description.data))
    if source.data != description.data:
        raise InputError("the file is UTF-16 and is not checked", remedy="save it as UTF-8", file=file)
    starts: dict[int, int] = {}
    for element in source.root.walk():
        starts.setdefault(element.line, element.start)
    lines = {("link", link.name): link.line for link in description.links}
    lines |= {("joint", joint.name): joint.line for joint in description.joints}
    readable = tuple(
        replace(link, geometries=tuple(each for each in link.geometries if not (each.filename or "").endswith(_OWN)))
        for link in description.links
    )
    reading = read(new_urdf(replace(description, links=readable), file).encode(), file)
    places = [(0, source.root.start)]
    for part in reading.root.children:
        start = starts.get(lines.get((part.tag, part.get("name") or ""), 0), source.root.start)
        places += [(0, start) for _ in part.walk()]
    return reading, Expansion(reading.data, (file,), tuple(places))
