"""Where a description has what some program does not take as it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from robodyn.checks.bodies.masses import principal_moments
from robodyn.checks.context import Context
from robodyn.robot.urdf.source_positions import Span
from robodyn.robot.urdf.view import JointView

Found = tuple[Span, str]
_TINY = 1e-15
_SLACK = 1e-6
_FREEDOM = {"fixed": 0, "planar": 3, "floating": 6}


def massless(context: Context) -> Iterator[Found]:
    """Yield rigid groups that a joint moves, without mass or without moments of inertia."""
    for group in context.tree.groups[1:]:
        heavy = [link for link in group.links if link.mass]
        inert = len(heavy) > 1 or any(any(link.tensor or ()) for link in heavy)
        if group.mass is not None and (group.mass <= _TINY or not inert):
            yield group.links[0].element.span, f"link '{group.links[0].name}'"


def no_mass(context: Context) -> Iterator[Found]:
    """Yield links without mass that a joint moves."""
    for group in context.tree.groups[1:]:
        if not group.links[0].mass:
            yield group.links[0].element.span, f"link '{group.links[0].name}'"


def unphysical(context: Context) -> Iterator[Found]:
    """Yield tensors that no body has, also of the root and of links without mass; a tensor of zeros counts as none."""
    for link in context.tree.links:
        if link.tensor is None or not any(link.tensor):
            continue
        small, middle, large = principal_moments(link.tensor)
        if small <= 0.0 or small + middle < (1.0 - _SLACK) * large:
            assert link.inertial is not None, "it has a tensor"
            yield link.inertial.element.span, f"link '{link.name}'"


def no_tensor(context: Context) -> Iterator[Found]:
    for link in context.view.links:
        inertial = link.inertial
        if inertial is not None and (inertial.inertia_element is None or inertial.mass_element is None):
            yield inertial.element.span, f"link '{link.name}'"


def root_mass(context: Context) -> Iterator[Found]:
    root = context.tree.root
    if root.mass:
        yield root.element.span, f"link '{root.name}'"


def free_base(context: Context) -> Iterator[Found]:
    root = context.tree.root
    if root.name != "world":
        yield root.element.span, f"link '{root.name}'"


def types(*kinds: str) -> Callable[[Context], Iterator[Found]]:
    """Yield joints of some types."""

    def find(context: Context) -> Iterator[Found]:
        for joint in context.view.joints:
            if joint.type in kinds:
                yield joint.element.span, f"joint '{joint.name}'"

    return find


def friction(context: Context) -> Iterator[Found]:
    for joint in context.view.joints:
        if joint.friction.value:
            yield joint.friction.span, f"joint '{joint.name}'"


def mimic_leader(context: Context) -> Iterator[Found]:
    """Yield mimic joints whose leader is not there, or does not have as many degrees of freedom."""
    for joint in context.view.joints:
        if joint.mimic is None:
            continue
        leader = context.view.joint.get(joint.mimic.joint)
        if leader is None or _FREEDOM.get(leader.type, 1) != _FREEDOM.get(joint.type, 1):
            yield joint.mimic.element.span, f"joint '{joint.name}'"


def NAME(context: Context) -> Iterator[Found]:
    """Yield the robot, where it has no name."""
    root = context.view.root
    if not root.get("name"):
        yield root.span, "the robot"


def where(what: str, holds: Callable[[Any], bool]) -> Callable[[Context], Iterator[Found]]:
    """Yield links and joints of which something is given, and is so."""

    def find(context: Context) -> Iterator[Found]:
        parts: tuple[Any, ...] = context.view.joints
        if what == "name":
            parts = (*context.view.links, *parts)
        for part in parts:
            value = part.name if what == "name" else _VALUES[what](part)
            if value is not None and holds(value):
                yield part.element.span, f"{part.subject.kind} '{part.name}'"

    return find


def _range(joint: JointView) -> tuple[float, float] | None:
    limited = joint.type in ("revolute", "prismatic") and joint.limit is not None
    return joint.limit.range if limited and joint.limit is not None else None


_VALUES: dict[str, Callable[[JointView], Any]] = {
    "axis": lambda joint: joint.axis.values if joint.moves else None,
    "range": _range,
    "mimic": lambda joint: joint.mimic,
    "damping": lambda joint: joint.damping.value,
}
