"""Elements and attributes as they stand in the file, and line and column of byte offsets in its text."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import accumulate

BOM = b"\xef\xbb\xbf"
_NEWLINE = re.compile(rb"\r\n|\r|\n")
_TAG = re.compile(rb"<[^ \t\r\n/>]+")
_ATTRIBUTE = re.compile(rb"""[ \t\r\n]+([^ \t\r\n=>/]+)[ \t\r\n]*=[ \t\r\n]*("[^"]*"|'[^']*')""")
_BLOCK = 4096
_ALL_BUT_CONTINUATION = bytes(byte for byte in range(256) if byte & 0xC0 != 0x80)


@dataclass(frozen=True, slots=True)
class Span:
    """A piece of the text: `line` and `column` (in characters) of its start from 1, byte offsets [start, end)."""

    line: int
    column: int
    start: int
    end: int


class SourcePositions:
    """Where byte offsets of `data` lie; a line ends with LF, CR or CR LF, and a byte order mark takes no column.

    Each index costs one pass over the text, each question a bisection and at most two blocks of `_BLOCK` bytes.
    """

    def __init__(self, data: bytes, encoding: str) -> None:
        self.data = data
        self.encoding = encoding

    def span(self, start: int, end: int) -> Span:
        line = bisect_right(self._line_starts, start)
        first = self._line_starts[line - 1]
        return Span(line, start - first - self._continuations(start) + self._continuations(first) + 1, start, end)

    def decode(self, start: int, end: int) -> str:
        return self.data[start:end].decode(self.encoding)

    @cached_property
    def _line_starts(self) -> list[int]:
        first = len(BOM) if self.data.startswith(BOM) else 0
        return [first, *(newline.end() for newline in _NEWLINE.finditer(self.data))]

    @cached_property
    def _block_continuations(self) -> list[int]:
        """UTF-8 continuation bytes before each block; empty where a byte is a character."""
        if self.encoding != "utf-8" or self.data.isascii():
            return []
        blocks = range(0, len(self.data), _BLOCK)
        return list(accumulate((_count_continuations(self.data[i : i + _BLOCK]) for i in blocks), initial=0))

    def _continuations(self, offset: int) -> int:
        if not self._block_continuations:
            return 0
        block = offset // _BLOCK
        return self._block_continuations[block] + _count_continuations(self.data[block * _BLOCK : offset])


def _count_continuations(data: bytes) -> int:
    return len(data.translate(None, _ALL_BUT_CONTINUATION))


@dataclass(frozen=True, slots=True)
class Attribute:
    """`name="value"`: `value` as XML reads it, `span` of the whole, `value_span` of what is between the quotes."""

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
        return next((child for child in self.children if child.tag == tag), None)

    def findall(self, tag: str) -> list[Element]:
        return [child for child in self.children if child.tag == tag]

    def walk(self) -> Iterator[Element]:
        """Yield it and all that is in it, in the order of the text."""
        waiting = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting += reversed(element.children)

    def _scanned(self) -> tuple[Mapping[str, Attribute], Span]:
        """Return the attributes and the span of the start tag, which expat has accepted, from its bytes."""
        if self._start_tag is None:
            positions, attributes = self.positions, {}
            tag = _TAG.match(positions.data, self.start)
            assert tag is not None, "the XML parser accepted this tag"
            place = tag.end()
            while match := _ATTRIBUTE.match(positions.data, place):
                place = match.end()
                name = positions.decode(*match.span(1))
                span, value_span = positions.span(match.start(1), place), positions.span(match.start(2) + 1, place - 1)
                attributes[name] = Attribute(self.values[name], span, value_span)
            end = positions.data.index(b">", place) + 1
            self._start_tag = attributes, positions.span(self.start, end)
        return self._start_tag
