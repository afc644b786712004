"""Joints as far as they can be read; see `robodyn.checks.view`."""

from __future__ import annotations

from dataclasses import dataclass

from robodyn.checks.attributes import Numbers, OriginView, Subject, numbers, value_span
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.source_positions import Span

MOVING = frozenset({"revolute", "continuous", "prismatic", "floating", "planar"})
WITH_AXIS = frozenset({"revolute", "continuous", "prismatic", "planar"})
WITH_RANGE = frozenset({"revolute", "prismatic"})
JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")


@dataclass(frozen=True, slots=True, eq=False)
class LimitView:
    """<limit>."""

    element: Element
    lower: Numbers
    upper: Numbers
    effort: Numbers
    velocity: Numbers

    @classmethod
    def of(cls, element: Element) -> LimitView:
        lower, upper, effort, velocity = (
            numbers(element, name, 1) for name in ("lower", "upper", "effort", "velocity")
        )
        return cls(element, lower, upper, effort, velocity)

    @property
    def range(self) -> tuple[float, float] | None:
        """lower and upper, 0 where one is absent, as URDF has it; None where one cannot be read."""
        lower, upper = self.lower.or_default(0.0), self.upper.or_default(0.0)
        return None if lower is None or upper is None else (lower[0], upper[0])


@dataclass(frozen=True, slots=True, eq=False)
class MimicView:
    """<mimic>; `joint` is empty where it is missing, the multiplier of an absent attribute 1, the offset 0."""

    element: Element
    joint: str
    multiplier: Numbers
    offset: Numbers

    @classmethod
    def of(cls, element: Element) -> MimicView:
        multiplier, offset = (numbers(element, name, 1) for name in ("multiplier", "offset"))
        return cls(element, element.get("joint") or "", multiplier, offset)


@dataclass(frozen=True, slots=True, eq=False)
class JointView:
    """<joint>; its name, type, parent and child are empty where they are missing."""

    element: Element
    name: str
    type: str
    parent: str
    child: str
    origin: OriginView
    axis: Numbers
    limit: LimitView | None
    mimic: MimicView | None

    @classmethod
    def of(cls, element: Element) -> JointView:
        parent, child = (((end := element.find(tag)) and end.get("link")) or "" for tag in ("parent", "child"))
        limit, mimic = element.find("limit"), element.find("mimic")
        return cls(
            element,
            element.get("name") or "",
            element.get("type") or "",
            parent,
            child,
            OriginView.of(element),
            numbers(element.find("axis"), "xyz", 3),
            None if limit is None else LimitView.of(limit),
            None if mimic is None else MimicView.of(mimic),
        )

    @property
    def subject(self) -> Subject:
        return Subject("joint", self.name)

    @property
    def name_span(self) -> Span:
        return value_span(self.element, "name")

    @property
    def moves(self) -> bool:
        return self.type in MOVING
