"""Changes of a description's text that leave every other byte as it is."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from robodyn.robot.urdf.document import BOM, Element

_BLANK = b" \t"


@dataclass(frozen=True, slots=True)
class Edit:
    """Bytes [start, end) of the file, and the text to stand there instead."""

    start: int
    end: int
    text: str


def edited(data: bytes, edits: Iterable[Edit], encoding: str) -> bytes:
    """Return the text with edits made that do not touch each other; insertions at one place stand in the order given.
    What the encoding lacks is written as a character reference."""
    parts, place = [], 0
    for edit in sorted(edits, key=lambda edit: edit.start):
        parts += [data[place : edit.start], edit.text.encode(encoding, "xmlcharrefreplace")]
        place = edit.end
    return b"".join([*parts, data[place:]])


def with_attributes(element: Element, values: Mapping[str, str]) -> Iterator[Edit]:
    """Yield the edits that give an element's attributes these values; values contain no quotes and no markup."""
    missing = ""
    for name, value in values.items():
        attribute = element.attributes.get(name)
        if attribute is None:
            missing += f' {name}="{value}"'
        elif attribute.value != value:
            yield Edit(attribute.value_span.start, attribute.value_span.end, value)
    if missing:
        ends = [attribute.span.end for attribute in element.attributes.values()]
        place = max(ends, default=element.start + 1 + len(element.tag.encode(element.positions.encoding)))
        yield Edit(place, place, missing)


def with_first_child(element: Element, lines: Sequence[str]) -> Edit:
    """Return the edit that puts a child before an element's others, indented as they are where each has its own line;
    two blanks for each level within its lines."""
    data, end = element.positions.data, element.span.end
    own = _indent(data, element.start)
    first = None if not element.children else _indent(data, element.children[0].start)
    closed = data[end - 2 : end] == b"/>"
    newline = "" if own is None else "\r\n" if b"\r\n" in data else "\n"
    inner = "" if own is None else first if first is not None else f"{own}  "
    body = "".join(f"{newline}{inner}{line if newline else line.strip()}" for line in lines)
    if not closed:
        return Edit(end, end, body)
    return Edit(end - 2, end, f">{body}{newline}{own or ''}</{element.tag}>")


def with_comment(data: bytes, lines: Sequence[str]) -> Edit:
    """Return the edit that puts a comment before the first element, behind the XML declaration."""
    newline = "\r\n" if b"\r\n" in data else "\n"
    text = re.sub("-(?=-)", "- ", newline.join(lines))
    comment = f"<!-- {text}{' ' if len(lines) == 1 else newline}-->"
    start = len(BOM) if data.startswith(BOM) else 0
    if data.startswith(b"<?xml", start):
        end = data.index(b"?>", start) + 2
        return Edit(end, end, newline + comment)
    return Edit(start, start, comment + newline)


def _indent(data: bytes, start: int) -> str | None:
    """Return the blanks before a tag that is the first thing in its line; None of another."""
    line = max(data.rfind(b"\n", 0, start), data.rfind(b"\r", 0, start)) + 1
    before = data[line:start]
    return before.decode("ascii") if line and not before.strip(_BLANK) else None
