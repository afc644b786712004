"""Where the elements of an expanded xacro file were written.

xacro copies elements as it expands macros, and forgets where they came from. So each gets an attribute when its file is
parsed, which is copied with it, and is taken away again at the end.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any
from xml.dom.expatbuilder import ExpatBuilderNS

_MARK = "robodyn-place"
_PREFIX = "xacro:"


class Places:
    """What stands in for xacro's parser: `parse`, and what it has noted.

    Args:
        read: returns the bytes of a file.
        parse: xacro's own, for what is no file, and for what is said of one that cannot be read.

    Attributes:
        files: those that were parsed.
        sources: their bytes.
    """

    def __init__(self, read: Callable[[str], bytes], parse: Callable[..., Any]) -> None:
        self._read, self._parse = read, parse
        self.files: list[str] = []
        self.sources: dict[str, bytes] = {}

    def parse(self, given: Any, filename: str | None = None) -> Any:
        """Return the document of a file, with marks."""
        if given is not None or filename is None:
            return self._parse(given, filename)
        try:
            data = self._read(filename)
        except OSError:
            return self._parse(None, filename)
        self.files.append(os.path.abspath(filename))
        self.sources[self.files[-1]] = data
        return _Marking(len(self.files) - 1).parseString(data)

    def taken(self, root: Any) -> list[tuple[int, int]]:
        """Return the file and the byte of each element in their order, and take the marks away."""
        places: list[tuple[int, int]] = []
        waiting = [(root, (0, 0))]
        while waiting:
            element, around = waiting.pop()
            mark = element.getAttribute(_MARK)
            if mark:
                element.removeAttribute(_MARK)
                number, _, start = mark.partition(" ")
                around = int(number), int(start)
            places.append(around)
            inner = [child for child in element.childNodes if child.nodeType == child.ELEMENT_NODE]
            waiting += [(child, around) for child in reversed(inner)]
        return places


class _Marking(ExpatBuilderNS):
    """Python's builder of documents, which marks each element but xacro's own."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self._number = number

    def start_element_handler(self, name: str, attributes: Any) -> None:
        super().start_element_handler(name, attributes)
        element: Any = self.curNode
        if not element.tagName.startswith(_PREFIX):
            element.setAttribute(_MARK, f"{self._number} {self.getParser().CurrentByteIndex}")
