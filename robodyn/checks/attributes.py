"""Attributes as rules read them: numbers, poses and names that never raise, with the element they come from."""

from __future__ import annotations

from dataclasses import dataclass

from robodyn.checks.reading import unexpanded
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import NumbersError, parse_numbers
from robodyn.robot.urdf.source_positions import Span

_LONGEST = 2000
"""Characters of the longest attribute that is read as numbers."""


@dataclass(frozen=True, slots=True)
class Subject:
    """The part of the robot that a finding is about: its kind (robot, link, joint, ...) and its name."""

    kind: str
    name: str


@dataclass(frozen=True, slots=True, eq=False)
class Numbers:
    """The numbers of one attribute: `values` is None where it is absent (`given` is False) or cannot be read.

    `element` is None where the element that would hold the attribute is absent, too.
    """

    element: Element | None
    attribute: str
    given: bool
    values: tuple[float, ...] | None
    problem: NumbersError | None = None

    @property
    def value(self) -> float | None:
        """The first number, which of most attributes is the only one."""
        return None if self.values is None else self.values[0]

    @property
    def span(self) -> Span:
        """What stands between the quotes; of an absent attribute the element's start tag."""
        assert self.element is not None, "a number without an element has no place"
        return value_span(self.element, self.attribute)

    def or_default(self, *default: float) -> tuple[float, ...] | None:
        """The values; the default where the attribute is absent; None where it cannot be read."""
        return self.values if self.given else default


def numbers(element: Element | None, attribute: str, count: int) -> Numbers:
    if element is None or (text := element.values.get(attribute)) is None:
        return Numbers(element, attribute, False, None)
    if unexpanded(text):
        return Numbers(element, attribute, True, None)
    try:
        if len(text) > _LONGEST:
            raise NumbersError(f"has {len(text)} characters", f"write {count} numbers")
        return Numbers(element, attribute, True, parse_numbers(text, count, element.tag))
    except NumbersError as error:
        return Numbers(element, attribute, True, None, error)


def value_span(element: Element, attribute: str) -> Span:
    """What stands between the quotes of an attribute; the start tag where it is absent."""
    found = element.attributes.get(attribute)
    return element.span if found is None else found.value_span


@dataclass(frozen=True, slots=True, eq=False)
class OriginView:
    """A pose: of an absent element or attribute, zero."""

    element: Element | None
    xyz: Numbers
    rpy: Numbers

    @classmethod
    def of(cls, owner: Element) -> OriginView:
        element = owner.find("origin")
        return cls(element, numbers(element, "xyz", 3), numbers(element, "rpy", 3))
