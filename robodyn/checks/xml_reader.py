"""The events of expat as elements with their places, and as faults."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from xml.parsers import expat

from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.source_positions import BOM, Places, Span
from robodyn.support.wording import shown

MAX_DEPTH = 200
RUN_XACRO = "name it FILE.xacro, and it is expanded first"
OWN_TAGS = frozenset({"link", "joint", "material", "transmission"})
"""Elements of the robot whose content is URDF's; all others belong to other tools and are not read."""
_DOCTYPE = b"<!DOCTYPE"
_UNDEFINED_ENTITY = 11
_ENTITY = re.compile(rb"&(?!(?:amp|lt|gt|quot|apos|#\w+);)[^;]*;?")
_REMEDIES = {
    "duplicate attribute": "keep one of the two",
    "junk after document element": "keep one <robot> and nothing after it",
    "XML or text declaration not at start of entity": "nothing, not even a blank, may stand before <?xml",
    "encoding specified in XML declaration is incorrect": "correct encoding=... in the first line",
    "unknown encoding": "save it as UTF-8",
    "no element found": "the file may be cut off, or an end tag is missing",
    "mismatched tag": "close every element in the order in which they were opened",
    "not well-formed (invalid token)": "write & as &amp; and < as &lt;, and put values in quotes",
}
_KINDS = {"sdf": "this is SDF; convert it to URDF", "mujoco": "this is MJCF; convert it to URDF"}


@dataclass(frozen=True, slots=True)
class TextFault:
    """Something that rule `code` reports about the file as XML."""

    code: str
    at: Span
    what: str
    remedy: str


class _UnreadableError(Exception):
    """Nothing after this place can be read."""


class Reader:
    """One parse: expat's events become elements and faults."""

    def __init__(self, data: bytes, encoding: str | None) -> None:
        self.places = Places(data, "utf-8")
        self.faults: list[TextFault] = []
        self._root: Element | None = None
        self._stack: list[Element] = []
        self._texts: list[list[str]] = []
        self._prefixes: list[set[str]] = [{"xml", "xmlns"}]
        self._unexpanded = False
        self._whole = False
        self._may_have_xacro = b"${" in data or b"$(" in data
        self._parser = parser = expat.ParserCreate(encoding)
        parser.buffer_text = True
        parser.XmlDeclHandler = self._declare if encoding is None else None
        parser.StartDoctypeDeclHandler = self._doctype
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._text

    def run(self) -> Element | None:
        """The root, if it is one that can be checked."""
        if not self.places.data.removeprefix(BOM).strip():
            self._add("RD001", 0, 0, "the file is empty", "give a URDF file")
        elif self._parse() and self._root is not None and self._root.tag != "robot":
            span = self._root.span
            remedy = _KINDS.get(self._root.tag, "give a URDF file, whose root element is <robot>")
            self._add("RD001", span.start, span.end, f"the root element is <{self._root.tag}>", remedy)
        elif self._whole and not self._unexpanded:
            return self._root
        return None

    def _parse(self) -> bool:
        """Whether the file could be read to its end."""
        try:
            self._parser.Parse(self.places.data, True)
            self._whole = True
        except _UnreadableError:
            pass
        except expat.ExpatError as error:
            self._malformed(error)
        except (LookupError, ValueError) as error:
            self.places.encoding = "utf-8"  # in which excerpts are shown
            self._add("RD001", 0, 0, f"the text cannot be decoded: {error}", "save it as UTF-8")
        return self._whole

    def _add(self, code: str, start: int, end: int, what: str, remedy: str) -> None:
        first = len(BOM) if self.places.data.startswith(BOM) else 0
        self.faults.append(TextFault(code, self.places.span(max(start, first), max(end, first)), what, remedy))

    def _malformed(self, error: expat.ExpatError) -> None:
        start = max(self._parser.ErrorByteIndex, 0)
        end = min(start + 1, len(self.places.data))
        if error.code == _UNDEFINED_ENTITY:
            entity = _ENTITY.search(self.places.data, start)
            start, end = entity.span() if entity else (start, end)
            self._add("RD002", start, end, "an entity that XML does not define", "write & as &amp;")
            return
        text = expat.ErrorString(error.code)
        if "encoding" in text:
            self.places.encoding = "utf-8"
        inside = f" inside <{self._stack[-1].tag}> of line {self._stack[-1].line}" if self._stack else ""
        remedy = _REMEDIES.get(text, "correct the XML")
        if b"\0" in self.places.data:
            text, remedy = "this is a binary file, not XML", "give a URDF file"
        self._add("RD001", start, end, text + inside, remedy)

    def _declare(self, version: str, encoding: str | None, standalone: int) -> None:
        if encoding is not None:
            self.places.encoding = encoding.lower()

    def _doctype(self, name: str, system: str | None, public: str | None, has_declarations: int) -> None:
        start = self.places.data.rfind(_DOCTYPE, 0, self._parser.CurrentByteIndex + len(_DOCTYPE))
        what = "a document type with declarations" if has_declarations else "a document type"
        self._add("RD002", start, start + len(_DOCTYPE), f"{what} (<!DOCTYPE)", "delete it; URDF needs none")
        if has_declarations:
            raise _UnreadableError

    def _start(self, tag: str, values: Mapping[str, str]) -> None:
        element = Element(tag, values, self._parser.CurrentLineNumber, self._parser.CurrentByteIndex, self.places)
        if self._stack:
            self._stack[-1].children.append(element)
        else:
            self._root = element
        self._stack.append(element)
        self._texts.append([])
        if len(self._stack) > MAX_DEPTH:
            what = f"elements are nested more than {MAX_DEPTH} deep"
            self._add("RD001", element.start, element.start + 1, what, "URDF needs fewer than ten levels")
            raise _UnreadableError
        self._check_prefixes(element)
        if self._may_have_xacro and not self._in_extension():
            self._check_expressions(element)

    def _end(self, tag: str) -> None:
        self._stack.pop().text = "".join(self._texts.pop())
        self._prefixes.pop()

    def _text(self, text: str) -> None:
        self._texts[-1].append(text)

    def _in_extension(self) -> bool:
        return len(self._stack) > 2 and self._stack[1].tag not in OWN_TAGS

    def _check_prefixes(self, element: Element) -> None:
        declared = self._prefixes[-1]
        if ":" not in element.tag and not any(":" in name for name in element.values):
            self._prefixes.append(declared)
            return
        new = {name.partition(":")[2] for name in element.values if name.startswith("xmlns:")}
        self._prefixes.append(declared | new if new - declared else declared)
        for name in (element.tag, *element.values):
            prefix, colon, _ = name.partition(":")
            if not colon:
                continue
            start, end = _name_place(element, name)
            if prefix == "xacro":
                self._unexpanded |= not self._in_extension()
                self._add("RD004", start, end, f"{shown(name)} is left over from xacro", RUN_XACRO)
            elif prefix not in self._prefixes[-1] and not self._in_extension():
                what = f"the prefix of {shown(name)} is not declared"
                self._add("RD003", start, end, what, f'add xmlns:{prefix}="..." to <robot>')

    def _check_expressions(self, element: Element) -> None:
        for name, value in element.values.items():
            if unexpanded(value):
                span = element.attributes[name].value_span
                self._add("RD004", span.start, span.end, f"{name}={shown(value)} is left over from xacro", RUN_XACRO)


def unexpanded(text: str) -> bool:
    """Whether there is an expression in it that xacro should have replaced."""
    return "${" in text or "$(" in text


def _name_place(element: Element, name: str) -> tuple[int, int]:
    if name == element.tag:
        return element.start + 1, element.start + 1 + len(name.encode())
    span = element.attributes[name].span
    return span.start, span.start + len(name.encode())
