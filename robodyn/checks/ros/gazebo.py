"""The links and joints that plugins of Gazebo name."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.ros.srdf import Named
from robodyn.robot.urdf.elements import Element

_SIDES = ("left", "right", "leftfront", "leftrear", "rightfront", "rightrear")
_JOINTS = ("joint", "jointname", "jointnames", "mimicjoint", "actuatedjoint", *(f"{side}joint" for side in _SIDES))
_NAMES = {
    **dict.fromkeys(_JOINTS, "joint"),
    **dict.fromkeys(("bodyname", "linkname", "canonicalbody"), "link"),
}
"""Tags of plugins, in lower case and without _, whose text names a joint or a link.

Frames are left out: other programs make some of them.
"""
_WORLD = "world"


def named_by_plugins(gazebo: Element) -> Iterator[Named]:
    """Yield the joints and links that the plugins in an element <gazebo> name, without those that it makes itself."""
    made = {element.get("name") for element in _downward(gazebo) if element.tag.partition(":")[0] in ("joint", "link")}
    for plugin in (element for element in _downward(gazebo) if element.tag == "plugin"):
        for element in _downward(plugin):
            kind = _kind(element)
            for name in element.text.replace(",", " ").split() if kind and not element.children else ():
                if name.rpartition("::")[2] not in {_WORLD, *made}:
                    yield Named(kind, name.rpartition("::")[2], element, "")
            if element.tag == "virtualJoint" and (inner := element.find("name")) is not None and inner.text.strip():
                yield Named("joint", inner.text.strip(), inner, "")


def _kind(element: Element) -> str:
    return _NAMES.get(element.tag.lower().replace("_", ""), "")


def _downward(root: Element) -> Iterator[Element]:
    waiting = list(reversed(root.children))
    while waiting:
        element = waiting.pop()
        yield element
        waiting += reversed(element.children)
