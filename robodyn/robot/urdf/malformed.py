"""What is wrong with malformed XML, and the remedy, in better words than expat's where there are any."""

from __future__ import annotations

import re
from typing import NamedTuple
from xml.parsers import expat

from robodyn.robot.urdf.elements import Element
from robodyn.support.wording import shown

BINARY = "this is a binary file, not XML", "give a URDF file"
_UNDEFINED_ENTITY = 11
_INVALID_TOKEN = 4
_ENTITY = re.compile(rb"&(?!(?:amp|lt|gt|quot|apos|#\w+);)[^;]*;?")
_REMEDIES = {
    "duplicate attribute": "keep one of the two",
    "junk after document element": "keep one <robot> and nothing after it",
    "XML or text declaration not at start of entity": "nothing, not even a blank, may stand before <?xml",
    "encoding specified in XML declaration is incorrect": "correct encoding=... in the first line",
    "unknown encoding": "save it as UTF-8",
    "undefined entity": "write & as &amp;",
}
_HINTS = {
    "no element found": "the file may be cut off, or an end tag is missing",
    "mismatched tag": "close every element in the order in which they were opened",
    "not well-formed (invalid token)": "write & as &amp; and < as &lt;, and put values in quotes",
}
"""Remedies of rules; strict reading says which element is open instead."""
_NO_BREAK_SPACE = "\u00a0".encode()


class Malformed(NamedTuple):
    """Why a file is not XML.

    Attributes:
        code: of the rule; start, end: bytes; what, remedy: as the rule has them.
        strict: what is wrong, and the remedy, as strict reading has them.
    """

    code: str
    start: int
    end: int
    what: str
    remedy: str
    strict: tuple[str, str | None]


def malformed(error: int, data: bytes, start: int, inside: Element | None, root: Element | None) -> Malformed:
    """Return what is wrong.

    Args:
        error, start: expat's code, and the byte.
        inside: the element that is open; root: the first of the file; None without one.
    """
    text = expat.ErrorString(error)
    strict = _strict(text, inside, root)
    end = min(start + 1, len(data))
    if error == _UNDEFINED_ENTITY:
        entity = _ENTITY.search(data, start)
        start, end = entity.span() if entity else (start, end)
        return Malformed("RD002", start, end, "an entity that XML does not define", _REMEDIES[text], strict)
    where = f" inside <{inside.tag}> of line {inside.line}" if inside else ""
    remedy = _REMEDIES.get(text) or _HINTS.get(text, "correct the XML")
    if data.startswith(_NO_BREAK_SPACE, start):
        text, remedy = "a non-breaking space (U+00A0)", "write a plain blank in its place"
    elif error == _INVALID_TOKEN:
        text, remedy = _invalid(data, start) or (text, remedy)
    if b"\0" in data:
        text, remedy = strict = BINARY
    return Malformed("RD001", start, end, text + where, remedy, strict)


def _strict(text: str, inside: Element | None, root: Element | None) -> tuple[str, str | None]:
    """Return what is wrong with malformed XML, and the remedy, as strict reading says it."""
    remedy = _REMEDIES.get(text)
    if inside:
        text += f" inside {shown(inside.tag)} of line {inside.line}"
        remedy = remedy or "the file may be cut off, or its end tag is missing"
    elif root is None and remedy is None:
        remedy = "the file must be XML with the root element <robot>"
    return f"malformed XML: {text}", remedy


def _invalid(data: bytes, start: int) -> tuple[str, str] | None:
    """Return why expat takes what begins here for no token of XML, and the remedy, where that can be told."""
    if data[start : start + 1] >= b"\x80":
        try:
            data[start : start + 4].decode()
        except UnicodeDecodeError as error:
            if error.start == 0:
                what = f"the byte 0x{data[start]:02X} is not of a text in UTF-8"
                return what, 'save the file as UTF-8, or name its encoding in <?xml version="1.0" encoding="..."?>'
    if data[start - 2 : start] == b"--" and data.rfind(b"<!--", 0, start - 2) > data.rfind(b"-->", 0, start):
        return "two hyphens in a comment, where only its end has them", "write one hyphen, or a blank between them"
    return None
