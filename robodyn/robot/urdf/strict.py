"""The policy of strict reading: the first fault of a view is raised, every default and every doubt is noted."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NoReturn, cast

from robodyn.errors import DescriptionError
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import TEXT, Numbers
from robodyn.robot.urdf.parts import ZERO, Note, Origin, Vector
from robodyn.robot.urdf.view import Part


@dataclass(frozen=True)
class Strict:
    """Values out of a view of one file; the defaults and warnings that they meet collect in `notes`.

    `owner` is the part of the robot that messages name.
    """

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
        children = [child for child in element.children if child.tag == tag]
        if len(children) > 1:
            what = f"{_where(element, owner)} has {len(children)} <{tag}> elements"
            raise self.error(children[1].line, what, "keep one of them")
        return children[0] if children else None

    def needed_child(self, element: Element, tag: str, owner: str) -> Element:
        child = self.child(element, tag, owner)
        if child is None:
            raise self.error(element.line, f"{_where(element, owner)} has no <{tag}>", f"add <{tag} .../>")
        return child

    def text(self, element: Element, attribute: str, owner: str) -> str:
        """Return an attribute that must be there and not be empty."""
        return element.get(attribute) or self._missing(element, attribute, owner)

    def given(self, read: Numbers, owner: str) -> tuple[float, ...] | None:
        """Return the numbers of an attribute, None where it is absent."""
        if read.problem is not None:
            assert read.element is not None, "it has the attribute"
            line, what = read.element.line, f"<{read.element.tag}> of {owner} {read.problem}"
            if read.attribute != TEXT:
                line, what = read.element.attributes[read.attribute].span.line, f"'{read.attribute}' in {what}"
            raise self.error(line, what, read.problem.remedy)
        return read.values

    def numbers(self, read: Numbers, owner: str, *default: float) -> tuple[float, ...]:
        """Return the numbers of an attribute; the default, which is noted, where it is absent and there is one."""
        numbers = read.values
        if numbers is None:
            self.given(read, owner)
            assert read.element is not None, "its element is there"
            if not default:
                self._missing(read.element, read.attribute, owner)
            written = " ".join(f"{number:g}" for number in default)
            self.default(read.element.line, f"<{read.element.tag}> of {owner} has no '{read.attribute}': {written}")
            return default
        return numbers

    def number(self, read: Numbers, owner: str, *default: float) -> float:
        return (read.values or self.numbers(read, owner, *default))[0]

    def vector(self, read: Numbers, owner: str, *default: float) -> Vector:
        return cast("Vector", self.numbers(read, owner, *default))

    def origin(self, part: Part, owner: str) -> Origin:
        """Return the pose of a part; zero where it says nothing."""
        if self.child(part.element, "origin", owner) is None:
            self.default(part.element.line, f"{_where(part.element, owner)} has no <origin>: 0 0 0")
            return Origin()
        return Origin(self.vector(part.origin.xyz, owner, *ZERO), self.vector(part.origin.rpy, owner, *ZERO))

    def _missing(self, element: Element, attribute: str, owner: str) -> NoReturn:
        state = "no" if element.get(attribute) is None else "an empty"
        what = f"{_where(element, owner)} has {state} attribute '{attribute}'"
        raise self.error(element.line, what, f'write {attribute}="..."')


def _where(element: Element, owner: str) -> str:
    """Return `owner` where the element is the owner itself, otherwise `<tag> of owner`."""
    return owner if owner.partition(" ")[0].strip("<>") == element.tag else f"<{element.tag}> of {owner}"
