"""Places where something is of which a program takes note, and how to look for them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

from robodyn.checks.context import Context
from robodyn.robot.urdf.elements import Element, Span
from robodyn.robot.urdf.view import JointView, LinkView


class Found(NamedTuple):
    """A place, what is there, and the mass of it where that is what matters [kg]."""

    at: Span
    what: str
    mass: float = 0.0


Find = Callable[[Context], Iterable[Found]]


def part(of: LinkView | JointView, element: Element | None = None) -> Found:
    """Return a link or joint at its start tag, or at that of an element in it."""
    return Found((element or of.element).span, named(of))


def named(of: LinkView | JointView) -> str:
    return f"{of.subject.kind} '{of.name}'"


def joints(holds: Callable[[JointView], object]) -> Find:
    """Return the joints of which something holds."""
    return lambda context: [part(joint) for joint in context.view.joints if holds(joint)]


def root(holds: Callable[[LinkView], object]) -> Find:
    """Return the root, if something holds of it."""
    return lambda context: [part(context.tree.root)] if holds(context.tree.root) else []


def when_asked(target: str, find: Find) -> Find:
    """Return what is found only for programs that are asked for: nearly every robot has meshes that cannot be read."""
    return lambda context: find(context) if target in context.asked.targets else ()


def nameless(context: Context) -> list[Found]:
    """Return the robot, where it has no name."""
    return [] if context.view.root.get("name") else [Found(context.view.root.span, "the robot")]
