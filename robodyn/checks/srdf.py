"""The SRDF that goes with a description, and the links and joints that it names."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from robodyn.checks.context import Context
from robodyn.errors import DescriptionError
from robodyn.robot.urdf.document import Document, Element, read_document

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
_FREE_BASE = "root_joint"  # Pinocchio's name for the joint of a free base
_MOST_READ = 20_000_000
_FEWEST = 3  # names that an SRDF must use at least for it to be known as another robot's by them


class Named(NamedTuple):
    """A name that an element uses for a link or a joint (`kind`)."""

    kind: str
    name: str
    element: Element
    attribute: str


def srdf_of(file: str, robot: str | None) -> Document | None:
    """Return the SRDF of the description's name in `_BESIDE`, or the only one there, if it is for this robot; None
    without one, or where it cannot be read, no fault of the robot's."""
    folder = Path(file).parent
    if not os.path.isfile(file):
        return None
    for same in (folder / sub / f"{Path(file).stem}.srdf" for sub in _BESIDE):
        if os.path.isfile(same):
            return document_or_none(same)
    alone = (found[0] for sub in _BESIDE if len(found := [*(folder / sub).glob("*.srdf")]) == 1)
    documents = (document_or_none(path) for path in alone if robot)
    return next((each for each in documents if each is not None and each.root.get("name") == robot), None)


def document_or_none(path: Path) -> Document | None:
    try:
        return read_document(path) if path.stat().st_size < _MOST_READ else None
    except (OSError, DescriptionError):
        return None


@dataclass(frozen=True, eq=False)
class Srdf:
    """The SRDF that goes with a description, every use in it of the name of a link or a joint, and of each that the
    robot does not have the first; one that is no namesake of the description's may be of a variant of the robot."""

    document: Document
    is_namesake: bool
    used: tuple[Named, ...]
    missing: tuple[Named, ...]

    @property
    def root(self) -> Element:
        return self.document.root

    @property
    def is_of_another(self) -> bool:
        """Whether its file has the description's name, and most of the names in it are not in the robot."""
        names = {(used.kind, used.name) for used in self.used}
        return self.is_namesake and len(names) >= _FEWEST and 2 * len(self.missing) > len(names)


def srdf(context: Context) -> Srdf | None:
    """The SRDF of a description (see `srdf_of`)."""
    file, view = context.reading.file, context.view
    document = srdf_of(file, view.root.get("name"))
    if document is None:
        return None
    virtual = {_FREE_BASE, *(child.get("name") for child in document.root.findall("virtual_joint"))}
    used = list[Named]()
    for element in document.root.walk():
        uses = [("link", element, attribute) for attribute in _LINKS.get(element.tag, ())]
        if element.tag in _JOINTS:
            uses.append(("joint", element, _JOINTS[element.tag]))
        if element.tag in ("group", "group_state"):
            uses += [(kind, child, "name") for kind in ("link", "joint") for child in element.findall(kind)]
        for kind, one, attribute in uses:
            if (name := one.get(attribute)) and (kind == "link" or name not in virtual):
                used.append(Named(kind, name, one, attribute))
    missing: dict[tuple[str, str], Named] = {}
    for each in used:
        if each.name not in (view.link if each.kind == "link" else view.joint):
            missing.setdefault((each.kind, each.name), each)
    return Srdf(document, Path(document.file).stem == Path(file).stem, tuple(used), tuple(missing.values()))


def own_srdf(context: Context) -> Srdf | None:
    """The SRDF, unless it is another robot's, of which RD706 tells."""
    found = context.once(srdf)
    return None if found is None or found.is_of_another else found
