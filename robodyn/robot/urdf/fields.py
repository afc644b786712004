"""Reading children, names and numbers of elements, each with a clear error or a recorded default."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import cast

from robodyn.errors import DescriptionError
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import NumbersError, parse_numbers
from robodyn.robot.urdf.parts import ZERO, Note, Origin, Vector


@dataclass(frozen=True)
class Fields:
    """Readers for the elements of one file; the defaults and warnings they meet collect in `notes`."""

    file: str
    notes: list[Note] = field(default_factory=list)

    def error(self, line: int, what: str, remedy: str) -> DescriptionError:
        return DescriptionError(what, remedy=remedy, file=self.file, line=line)

    def default(self, line: int, what: str) -> None:
        self.notes.append(Note(line, what, "default"))

    def warn(self, line: int, what: str) -> None:
        self.notes.append(Note(line, what, "warning"))

    def child(self, element: Element, tag: str, owner: str) -> Element | None:
        """Return the child with that tag, of which there may be one at most."""
        children = element.findall(tag)
        if len(children) > 1:
            raise self.error(
                children[1].line, f"{_where(element, owner)} has {len(children)} <{tag}> elements", "keep one of them"
            )
        return children[0] if children else None

    def needed_child(self, element: Element, tag: str, owner: str) -> Element:
        child = self.child(element, tag, owner)
        if child is None:
            raise self.error(element.line, f"{_where(element, owner)} has no <{tag}>", f"add <{tag} .../>")
        return child

    def name(self, element: Element, attribute: str, owner: str) -> str:
        """Return an attribute that must be there and not be empty."""
        value = element.get(attribute)
        if not value:
            raise self.missing(element, attribute, owner)
        return value

    def missing(self, element: Element, attribute: str, owner: str) -> DescriptionError:
        state = "no" if element.get(attribute) is None else "an empty"
        return self.error(
            element.line, f"{_where(element, owner)} has {state} attribute '{attribute}'", f'write {attribute}="..."'
        )

    def numbers(self, element: Element, attribute: str, count: int, owner: str) -> tuple[float, ...] | None:
        """Return the numbers of an attribute, None where it is absent."""
        text = element.get(attribute)
        if text is None:
            return None
        try:
            return parse_numbers(text, count, element.tag)
        except NumbersError as error:
            line = element.attributes[attribute].span.line
            what = f"'{attribute}' in <{element.tag}> of {owner} {error}"
            raise self.error(line, what, error.remedy) from None

    def number(self, element: Element, attribute: str, owner: str) -> float | None:
        numbers = self.numbers(element, attribute, 1, owner)
        return None if numbers is None else numbers[0]

    def needed_number(self, element: Element, attribute: str, owner: str) -> float:
        number = self.number(element, attribute, owner)
        if number is None:
            raise self.missing(element, attribute, owner)
        return number

    def number_or(self, default: float, element: Element, attribute: str, owner: str) -> float:
        number = self.number(element, attribute, owner)
        if number is None:
            self.default(element.line, f"<{element.tag}> of {owner} has no '{attribute}': {default:g}")
            return default
        return number

    def vector(self, element: Element, attribute: str, owner: str) -> Vector | None:
        return cast("Vector | None", self.numbers(element, attribute, 3, owner))

    def origin(self, element: Element, owner: str) -> Origin:
        """Return the pose in the child <origin>; zero where it says nothing."""
        origin = self.child(element, "origin", owner)
        if origin is None:
            self.default(element.line, f"{_where(element, owner)} has no <origin>: 0 0 0")
            return Origin()
        return Origin(self.vector_or_zero(origin, "xyz", owner), self.vector_or_zero(origin, "rpy", owner))

    def vector_or_zero(self, element: Element, attribute: str, owner: str) -> Vector:
        vector = self.vector(element, attribute, owner)
        if vector is None:
            self.default(element.line, f"<{element.tag}> of {owner} has no '{attribute}': 0 0 0")
            return ZERO
        return vector


def _where(element: Element, owner: str) -> str:
    """Return `owner` where the element is the owner itself, otherwise `<tag> of owner`."""
    return owner if owner.partition(" ")[0].strip("<>") == element.tag else f"<{element.tag}> of {owner}"
