"""Line and column of byte offsets in a text, from two indices that are built when the first one is asked for."""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate

BOM = b"\xef\xbb\xbf"
_NEWLINE = re.compile(rb"\r\n|\r|\n")
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
    """Where byte offsets of `data` lie.

    A line ends with LF, CR or CR LF; a byte order mark takes no column. Each index costs one pass over the text,
    each question a bisection and at most two blocks of `_BLOCK` bytes, however long the lines are.
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
        """Return the number of UTF-8 continuation bytes before `offset`."""
        if not self._block_continuations:
            return 0
        block = offset // _BLOCK
        return self._block_continuations[block] + _count_continuations(self.data[block * _BLOCK : offset])


def _count_continuations(data: bytes) -> int:
    return len(data.translate(None, _ALL_BUT_CONTINUATION))
