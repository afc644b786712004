"""The file as written: every element and attribute of a URDF, with its place, and everything that is wrong as XML.

A file is parsed once, and what is wrong with it is data. `read` keeps all of that, as a linter wants it;
`read_document` is strict and raises the first.
"""

from __future__ import annotations

import os
from dataclasses import dataclass

from robodyn.errors import DescriptionError
from robodyn.robot.urdf.elements import Element, SourcePositions
from robodyn.robot.urdf.sources import LONGEST, as_utf8, long_token, read_source
from robodyn.robot.urdf.xml_reader import Reader, TextFault

_SHOWN = 200
"""Bytes kept of a token that is too long."""


@dataclass(frozen=True, eq=False)
class Document:
    """A parsed file, and what is wrong with it as XML. Spans are byte offsets into `data`, text in `encoding`.

    Attributes:
        data: the bytes of the file, except for UTF-16, which is transcoded to UTF-8 first.
        robot: the element <robot>, where the file could be read to the end and needs no expansion.
    """

    file: str
    data: bytes
    encoding: str
    faults: tuple[TextFault, ...]
    robot: Element | None

    @property
    def root(self) -> Element:
        """<robot>, of a file that could be read."""
        assert self.robot is not None, "the file could be read"
        return self.robot

    def found(self, code: str) -> list[TextFault]:
        """Return what rule `code` reports."""
        return [fault for fault in self.faults if fault.code == code]


def read_document(source: str | os.PathLike[str] | bytes, name: str | None = None) -> Document:
    """Return the elements and attributes of a URDF file with their places.

    Args:
        source: path of the file, or its bytes.
        name: the file as messages shall show it; by default the path, and `<stdin>` for bytes.

    Returns:
        The document; its root element is `<robot>`. Elements and attributes that URDF does not know are kept.

    Raises:
        DescriptionError: the file cannot be read, is not XML or not URDF, has a document type, an undeclared
            prefix outside the extension elements, or is left over from xacro; with the line.
    """
    file, original = read_source(source, name)
    document = _parsed(file, *as_utf8(file, original))
    if document.faults:
        raise document.faults[0].error
    return document


def read(source: str | os.PathLike[str] | bytes, name: str | None = None) -> Document:
    """Return what can be read of a file, with all its faults.

    Args:
        source, name: as for `read_document`.

    Raises:
        DescriptionError: the file cannot be opened.
    """
    file, original = read_source(source, name)
    try:
        data, transcoded = as_utf8(file, original)
    except DescriptionError as error:
        at, remedy = SourcePositions(original, "latin-1").span(0, 0), error.remedy or "save as UTF-8"
        return Document(file, original, "latin-1", (TextFault("RD001", at, error.what, remedy, error),), None)
    if (long := long_token(data)) is not None:
        return _unread(file, data, *long)
    return _parsed(file, data, transcoded)


def _parsed(file: str, data: bytes, transcoded: bool) -> Document:
    """Parse the text by expat, which fetches nothing: what declares entities ends the reading before any is expanded.

    Method: one pass, no recursion.
    """
    reader = Reader(file, data, "utf-8" if transcoded else None)
    root, encoding = reader.run(), reader.positions.encoding
    return Document(file, data, encoding, tuple(reader.faults), root)


def _unread(file: str, data: bytes, start: int, end: int, kind: str) -> Document:
    """Return a file with a token that is too long: its data end soon after that has begun."""
    what = f"{kind} of {end - start} bytes; more than {LONGEST} from one tag to the next are not read"
    remedy = "shorten it; no robot needs as much"
    seen = data[: min(start + _SHOWN, end)]
    at = SourcePositions(seen, "utf-8").span(start, len(seen))
    error = DescriptionError(what, remedy=remedy, file=file, line=at.line)
    return Document(file, seen, "utf-8", (TextFault("RD001", at, what, remedy, error),), None)
