"""Elements and attributes as they stand in the file."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from robodyn.robot.urdf.source_positions import SourcePositions, Span

_TAG = re.compile(rb"<[^ \t\r\n/>]+")
_ATTRIBUTE = re.compile(rb"""[ \t\r\n]+([^ \t\r\n=>/]+)[ \t\r\n]*=[ \t\r\n]*("[^"]*"|'[^']*')""")
_TAG_END = re.compile(rb"[ \t\r\n]*/?>")


@dataclass(frozen=True, slots=True)
class Attribute:
    """`name="value"`: `value` as XML reads it, `span` of the whole, `value_span` of what is between the quotes."""

    name: str
    value: str
    span: Span
    value_span: Span


@dataclass(eq=False, slots=True)
class Element:
    """An element: `values` of its attributes, and `attributes` with their places, found when first asked for.

    `text` is the character data directly inside it, `start` the byte offset of its start tag, `line` the tag's line.
    """

    tag: str
    values: Mapping[str, str]
    line: int
    start: int
    positions: SourcePositions = field(repr=False)
    children: list[Element] = field(default_factory=list, repr=False)
    text: str = ""
    _start_tag: tuple[Mapping[str, Attribute], Span] | None = field(default=None, repr=False)

    @property
    def attributes(self) -> Mapping[str, Attribute]:
        """The attributes by name, in the order of the file."""
        return self._scanned()[0]

    @property
    def span(self) -> Span:
        """The start tag, from `<` to `>`."""
        return self._scanned()[1]

    def get(self, name: str) -> str | None:
        return self.values.get(name)

    def find(self, tag: str) -> Element | None:
        """Return the first child with that tag."""
        for child in self.children:
            if child.tag == tag:
                return child
        return None

    def findall(self, tag: str) -> list[Element]:
        return [child for child in self.children if child.tag == tag]

    def _scanned(self) -> tuple[Mapping[str, Attribute], Span]:
        if self._start_tag is None:
            self._start_tag = _scan(self)
        return self._start_tag


def _scan(element: Element) -> tuple[Mapping[str, Attribute], Span]:
    """Return the attributes and the span of a start tag that expat has accepted, from its bytes."""
    positions = element.positions
    attributes = {}
    position = _end(_TAG.match(positions.data, element.start))
    while match := _ATTRIBUTE.match(positions.data, position):
        position = match.end()
        name = positions.decode(*match.span(1))
        value_span = positions.span(match.start(2) + 1, position - 1)
        attributes[name] = Attribute(name, element.values[name], positions.span(match.start(1), position), value_span)
    return attributes, positions.span(element.start, _end(_TAG_END.match(positions.data, position)))


def _end(match: re.Match[bytes] | None) -> int:
    assert match is not None, "the XML parser accepted this tag"
    return match.end()
