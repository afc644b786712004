"""Links, joints and numbers of a file as far as they can be read.

The strict reader (`robodyn.robot.urdf.description`) raises at the first fault. Rules read through this view instead:
nothing in it raises, what is missing or unreadable is None, and every part knows the element it comes from. Of several
children with one tag the first counts, as in urdfdom. One pass over the links and joints, no recursion.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol, TypeVar

from robodyn.checks.attributes import Numbers, OriginView, Subject, numbers, value_span
from robodyn.checks.joint_view import JOINT_TYPES, MOVING, WITH_AXIS, WITH_RANGE, JointView, LimitView, MimicView
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.source_positions import Span

__all__ = [
    "INERTIA",
    "JOINT_TYPES",
    "MOVING",
    "SHAPES",
    "WITH_AXIS",
    "WITH_RANGE",
    "GeometryView",
    "InertialView",
    "JointView",
    "LimitView",
    "LinkView",
    "MimicView",
    "Numbers",
    "OriginView",
    "Subject",
    "View",
    "numbers",
    "value_span",
]

INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
SHAPES = ("box", "cylinder", "sphere", "capsule", "mesh")


@dataclass(frozen=True, slots=True, eq=False)
class InertialView:
    """<inertial>: `mass_element` and `inertia_element` are None where it has none."""

    element: Element
    origin: OriginView
    mass_element: Element | None
    mass: Numbers
    inertia_element: Element | None
    entries: tuple[Numbers, ...]

    @classmethod
    def of(cls, element: Element) -> InertialView:
        mass, inertia = element.find("mass"), element.find("inertia")
        entries = tuple(numbers(inertia, name, 1) for name in INERTIA)
        return cls(element, OriginView.of(element), mass, numbers(mass, "value", 1), inertia, entries)

    @property
    def tensor(self) -> tuple[float, ...] | None:
        """ixx, ixy, ixz, iyy, iyz, izz [kg m^2], if all six can be read."""
        values = tuple(entry.values[0] for entry in self.entries if entry.values is not None)
        return values if len(values) == len(INERTIA) else None


@dataclass(frozen=True, slots=True, eq=False)
class GeometryView:
    """<visual> or <collision> (`kind`), and the first shape in it; `sizes` as the shape's attributes have them."""

    element: Element
    kind: str
    origin: OriginView
    shape: Element | None

    @classmethod
    def of(cls, element: Element) -> GeometryView:
        geometry = element.find("geometry")
        shapes = [] if geometry is None else [child for child in geometry.children if child.tag in SHAPES]
        return cls(element, element.tag, OriginView.of(element), shapes[0] if shapes else None)


@dataclass(frozen=True, slots=True, eq=False)
class LinkView:
    """<link>; its name is empty where it has none."""

    element: Element
    name: str
    inertial: InertialView | None
    geometries: tuple[GeometryView, ...]

    @classmethod
    def of(cls, element: Element) -> LinkView:
        inertial = element.find("inertial")
        shapes = tuple(GeometryView.of(child) for child in element.children if child.tag in ("visual", "collision"))
        view = None if inertial is None else InertialView.of(inertial)
        return cls(element, element.get("name") or "", view, shapes)

    @property
    def subject(self) -> Subject:
        return Subject("link", self.name)

    @property
    def name_span(self) -> Span:
        return value_span(self.element, "name")

    @property
    def mass(self) -> float | None:
        """kg; 0 without an <inertial>; None where it is missing in one or cannot be read."""
        return 0.0 if self.inertial is None else self.inertial.mass.value

    @property
    def tensor(self) -> tuple[float, ...] | None:
        return None if self.inertial is None else self.inertial.tensor


class _Named(Protocol):
    @property
    def name(self) -> str: ...


N = TypeVar("N", bound=_Named)


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """`links` and `joints` in the order of the file; `link` and `joint` by name, the first of each name."""

    root: Element
    links: tuple[LinkView, ...]
    joints: tuple[JointView, ...]
    link: Mapping[str, LinkView]
    joint: Mapping[str, JointView]

    @classmethod
    def of(cls, root: Element) -> View:
        links = tuple(LinkView.of(element) for element in root.children if element.tag == "link")
        joints = tuple(JointView.of(element) for element in root.children if element.tag == "joint")
        return cls(root, links, joints, _by_name(links), _by_name(joints))


def _by_name(parts: Iterable[N]) -> dict[str, N]:
    named: dict[str, N] = {}
    for part in parts:
        if part.name:
            named.setdefault(part.name, part)
    return named
