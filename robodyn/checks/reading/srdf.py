"""The SRDF that goes with a description, and the links and joints that it names."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from robodyn.errors import DescriptionError
from robodyn.robot.urdf.document import read_document
from robodyn.robot.urdf.elements import Element

_BESIDE = ("", "config", "srdf", "../config", "../srdf")
"""Folders in which an SRDF is looked for, from that of the description."""
_LINKS = {
    "chain": ("base_link", "tip_link"),
    "end_effector": ("parent_link",),
    "virtual_joint": ("child_link",),
    "link_sphere_approximation": ("link",),
    "disable_default_collisions": ("link",),
    "disable_collisions": ("link1", "link2"),
    "enable_collisions": ("link1", "link2"),
}
_JOINTS = {"passive_joint": "name", "joint_property": "joint_name"}
_FREE_BASE = "root_joint"
"""Pinocchio's name for the joint of a free base."""
_MOST_READ = 20_000_000


class Named(NamedTuple):
    """A name that an element of a file uses for a link or a joint (`kind`)."""

    kind: str
    name: str
    element: Element
    attribute: str


def srdf_of(file: str, robot: str | None) -> Path | None:
    """Return the SRDF of the description's name beside it, or the only one there, if it is for the robot of that name.

    Looked for in the description's folder, in config and srdf in it, and in config and srdf beside it.
    """
    folder = Path(file).parent
    if not os.path.isfile(file):
        return None
    for sub in _BESIDE:
        same = folder / sub / f"{Path(file).stem}.srdf"
        if _readable(same):
            return same
    for sub in _BESIDE:
        found = sorted((folder / sub).glob("*.srdf")) if (folder / sub).is_dir() else []
        if len(found) == 1 and _readable(found[0]) and robot and _robot(found[0]) == robot:
            return found[0]
    return None


def names_in_srdf(path: Path) -> tuple[Named, ...]:
    """Return every use of a link's or a joint's name; none where the file cannot be read, which is no fault of the
    robot's."""
    try:
        root = read_document(path).root
    except DescriptionError:
        return ()
    virtual = {_FREE_BASE, *(child.get("name") for child in root.findall("virtual_joint"))}
    return tuple(named for named in _walk(root) if named.kind == "link" or named.name not in virtual)


def _walk(root: Element) -> Iterator[Named]:
    waiting = list(reversed(root.children))
    while waiting:
        element = waiting.pop()
        waiting += reversed(element.children)
        for attribute in _LINKS.get(element.tag, ()):
            yield from _named("link", element, attribute)
        if element.tag in _JOINTS:
            yield from _named("joint", element, _JOINTS[element.tag])
        if element.tag in ("group", "group_state"):
            for kind in ("link", "joint"):
                for child in element.findall(kind):
                    yield from _named(kind, child, "name")


def _named(kind: str, element: Element, attribute: str) -> Sequence[Named]:
    name = element.get(attribute)
    return () if not name else (Named(kind, name, element, attribute),)


def _robot(path: Path) -> str | None:
    try:
        return read_document(path).root.get("name")
    except DescriptionError:
        return None


def _readable(path: Path) -> bool:
    try:
        return path.is_file() and path.stat().st_size < _MOST_READ
    except OSError:
        return False
