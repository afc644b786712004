"""What <ros2_control> says: joints, sensors and gpio with the interfaces that they offer, and their parameters."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.view import Subject, View

_PARTS = ("joint", "sensor", "gpio")
_INTERFACES = ("command_interface", "state_interface")


class Controlled(NamedTuple):
    """A joint, sensor or gpio (`element`) of a <ros2_control>."""

    control: Element
    element: Element

    @property
    def subject(self) -> Subject:
        return Subject(self.element.tag, self.element.get("name") or "")

    @property
    def interfaces(self) -> list[Element]:
        return [child for child in self.element.children if child.tag in _INTERFACES]

    @property
    def is_commanded(self) -> bool:
        return self.element.find("command_interface") is not None


def controlled(view: View) -> Iterator[Controlled]:
    """Yield the parts of every <ros2_control>, in the order of the file."""
    for control in view.root.findall("ros2_control"):
        for element in control.children:
            if element.tag in _PARTS:
                yield Controlled(control, element)


def parameter(owner: Element, name: str) -> Element | None:
    """Return <param name="..."> in an element, the first of that name."""
    return next((child for child in owner.findall("param") if child.get("name") == name), None)
