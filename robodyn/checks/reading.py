"""The file as XML: its elements with their places, and everything that is wrong with it so far.

`robodyn.robot.urdf.document` refuses a file at the first fault; a linter collects them and reads on where it can.
"""

from __future__ import annotations

import os
from dataclasses import dataclass

from robodyn.checks.long_tokens import LONGEST, long_token
from robodyn.checks.xml_reader import Reader, TextFault, unexpanded
from robodyn.errors import DescriptionError
from robodyn.robot.urdf.document import Document
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.source_positions import Places
from robodyn.robot.urdf.sources import as_utf8, read_source

__all__ = ["Reading", "TextFault", "read", "unexpanded"]

_SHOWN = 200
"""Bytes kept of a token that is too long."""


@dataclass(frozen=True, eq=False)
class Reading:
    """A file, the faults of its XML, and its document where that could be read to the end and needs no expansion."""

    file: str
    data: bytes
    encoding: str
    faults: tuple[TextFault, ...]
    document: Document | None

    @property
    def root(self) -> Element:
        """<robot>. From stage DOCUMENT on."""
        assert self.document is not None, "the stage DOCUMENT has been reached"
        return self.document.root

    def found(self, code: str) -> list[TextFault]:
        """What rule `code` reports."""
        return [fault for fault in self.faults if fault.code == code]


def read(source: str | os.PathLike[str] | bytes, name: str | None = None) -> Reading:
    """The reading of a file.

    Method: expat, which fetches nothing; a document type with declarations ends the reading before any is expanded.

    Args:
        source: path of the file, or its bytes.
        name: the file as findings shall show it; by default the path, and `<stdin>` for bytes.

    Raises:
        DescriptionError: the file cannot be opened.
    """
    file, original = read_source(source, name)
    try:
        data, transcoded = as_utf8(file, original)
    except DescriptionError as error:
        fault = TextFault("RD001", Places(original, "latin-1").span(0, 0), error.what, error.remedy or "save as UTF-8")
        return Reading(file, original, "latin-1", (fault,), None)
    if (long := long_token(data)) is not None:
        return _unread(file, data, *long)
    reader = Reader(data, "utf-8" if transcoded else None)
    root = reader.run()
    places = reader.places
    document = None if root is None else Document(file, data, root, places.encoding)
    faults = tuple(sorted(reader.faults, key=lambda fault: fault.at.start))
    return Reading(file, data, places.encoding, faults, document)


def _unread(file: str, data: bytes, start: int, end: int, kind: str) -> Reading:
    """The reading of a file with a token that is too long: its data end soon after that has begun."""
    what = f"{kind} of {end - start} bytes; more than {LONGEST} from one tag to the next are not read"
    seen = data[: min(start + _SHOWN, end)]
    at = Places(seen, "utf-8").span(start, len(seen))
    return Reading(file, seen, "utf-8", (TextFault("RD001", at, what, "shorten it; no robot needs as much"),), None)
