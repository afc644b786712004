"""The file as written: every element and attribute of a URDF, with its place, and all that is wrong as XML: `read`
keeps it as data, as a linter wants it; `read_document` is strict and raises the first."""

from __future__ import annotations

import os
import re
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import accumulate
from xml.parsers import expat

from robodyn.errors import DescriptionError
from robodyn.robot.urdf.sources import LONGEST, OTHER_FORMATS, as_utf8, long_token, read_source
from robodyn.support.input_file import LFS_POINTER
from robodyn.support.wording import shown

BOM = b"\xef\xbb\xbf"
_NEWLINE = re.compile(rb"\r\n|\r|\n")
_TAG = re.compile(rb"<[^ \t\r\n/>]+")
_ATTRIBUTE = re.compile(rb"""[ \t\r\n]+([^ \t\r\n=>/]+)[ \t\r\n]*=[ \t\r\n]*("[^"]*"|'[^']*')""")
_BLOCK = 4096
_NO_CONTINUATION = bytes(byte for byte in range(256) if byte & 0xC0 != 0x80)


@dataclass(frozen=True, slots=True)
class Span:
    """A piece of the text: `line` and `column` (in characters) of its start from 1, byte offsets [start, end)."""

    line: int
    column: int
    start: int
    end: int


class SourcePositions:
    """Where byte offsets of `data` lie; a line ends with LF, CR or CR LF, and a byte order mark takes no column. Each
    index costs one pass over the text, each question a bisection and at most two blocks of `_BLOCK` bytes."""

    def __init__(self, data: bytes, encoding: str) -> None:
        self.data, self.encoding = data, encoding

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
        return list(
            accumulate((len(self.data[i : i + _BLOCK].translate(None, _NO_CONTINUATION)) for i in blocks), initial=0)
        )

    def _continuations(self, offset: int) -> int:
        if not self._block_continuations:
            return 0
        block = offset // _BLOCK
        rest = self.data[block * _BLOCK : offset].translate(None, _NO_CONTINUATION)
        return self._block_continuations[block] + len(rest)


@dataclass(frozen=True, slots=True)
class Attribute:
    """`name="value"`: `value` as XML reads it, `span` of the whole, `value_span` of what is between the quotes."""

    value: str
    span: Span
    value_span: Span


@dataclass(eq=False, slots=True)
class Element:
    """An element: `values` of its attributes, and `attributes` with their places, found when first asked for; `text` is
    the character data directly inside it, `start` the byte offset of its start tag, `line` the tag's line."""

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


MAX_DEPTH = 200
OWN_TAGS = frozenset({"link", "joint", "material", "transmission"})
"""Elements of the robot whose content is URDF's; all others belong to other tools and are not read."""
_RUN_XACRO = "name it FILE.xacro, and it is expanded first"
_DOCTYPE = b"<!DOCTYPE"
_NAMESPACES = {"drake": "http://drake.mit.edu"}
_BINARY = "this is a binary file, not XML", "give a URDF file"
_UNDEFINED_ENTITY, _INVALID_TOKEN = 11, 4
"""Codes of expat."""
_ENTITY = re.compile(rb"&(?!(?:amp|lt|gt|quot|apos|#\w+);)[^;]*;?")
_REMEDIES = {
    "duplicate attribute": "keep one of the two",
    "junk after document element": "keep one <robot> and nothing after it",
    "XML or text declaration not at start of entity": "nothing, not even a blank, may stand before <?xml",
    "encoding specified in XML declaration is incorrect": "correct encoding=... in the first line",
    "unknown encoding": "save it as UTF-8",
    "undefined entity": "write & as &amp;",
    "no element found": "the file may be cut off, or an end tag is missing",
    "unclosed token": "the file may be cut off, or an end tag is missing",
    "mismatched tag": "close every element in the order in which they were opened",
    "not well-formed (invalid token)": "write & as &amp; and < as &lt;, and put values in quotes",
}
_NO_BREAK_SPACE = "\u00a0".encode()


@dataclass(frozen=True, slots=True)
class TextFault:
    """Something wrong with the file as XML, which rule `code` reports; `syntax` if expat cannot read on behind it."""

    code: str
    at: Span
    what: str
    remedy: str
    syntax: bool = False

    def error(self, file: str) -> DescriptionError:
        """Return what strict reading raises."""
        what = f"malformed XML: {self.what}" if self.syntax else self.what
        return DescriptionError(what, remedy=self.remedy, file=file, line=self.at.line)


@dataclass(frozen=True, eq=False)
class Document:
    """A parsed file, and what is wrong with it as XML. Spans are byte offsets into `data`, text in `encoding`.

    Attributes:
        data: the bytes of the file, except for UTF-16, which is transcoded to UTF-8 first.
        robot: the root element, <robot> of a URDF, where the file could be read to the end and needs no expansion.
    """

    file: str
    data: bytes
    encoding: str
    faults: tuple[TextFault, ...]
    robot: Element | None

    @property
    def root(self) -> Element:
        """The root element, of a file that could be read."""
        assert self.robot is not None, "the file could be read"
        return self.robot

    def found(self, code: str) -> list[TextFault]:
        """Return what rule `code` reports."""
        return [fault for fault in self.faults if fault.code == code]


def read_document(source: str | os.PathLike[str] | bytes, name: str | None = None, root: str = "robot") -> Document:
    """Return the elements and attributes of a file, its path or bytes, with their places; `name` and `root` as `read`.

    Raises:
        DescriptionError: the file cannot be read, is not XML or has another root, has a document type, an undeclared
            prefix outside the extension elements, or is left over from xacro; with the line.
    """
    document = read(source, name, root)
    if document.faults:
        raise document.faults[0].error(document.file)
    return document


def read(source: str | os.PathLike[str] | bytes, name: str | None = None, root: str = "robot") -> Document:
    """Return what can be read of a file, with all its faults; DescriptionError where it cannot be opened.

    Args:
        name: the file as messages shall show it; by default the path, and `<stdin>` for bytes.
        root: the tag that the root element must have; only in a robot, which is URDF, are leftovers of xacro wrong.
    """
    file, original = read_source(source, name)
    try:
        data, transcoded = as_utf8(original)
    except UnicodeError as error:
        at = SourcePositions(original, "latin-1").span(0, 0)
        fault = TextFault("RD001", at, f"broken UTF-16: {error}", "save it as UTF-8")
        return Document(file, original, "latin-1", (fault,), None)
    if (long := long_token(data)) is not None:
        start, end, kind = long
        what = f"{kind} of {end - start} bytes; more than {LONGEST} from one tag to the next are not read"
        seen = data[: min(start + 200, end)]
        at = SourcePositions(seen, "utf-8").span(start, len(seen))
        fault = TextFault("RD001", at, what, "shorten it; no robot needs as much")
        return Document(file, seen, "utf-8", (fault,), None)
    reader = _Reader(file, data, "utf-8" if transcoded else None, root)
    element = reader.run()
    return Document(file, data, reader.positions.encoding, tuple(reader.faults), element)


def unexpanded(text: str) -> bool:
    """Return whether there is an expression in it that xacro should have replaced."""
    return "${" in text or "$(" in text


class _UnreadableError(Exception):
    """Nothing after this place can be read."""


class _Reader:
    """One parse by expat, which fetches nothing: its events become elements and faults, in the order of the file; what
    declares entities ends the reading before any is expanded."""

    def __init__(self, file: str, data: bytes, encoding: str | None, root: str = "robot") -> None:
        self.file, self.tag = file, root
        self.positions = SourcePositions(data, "utf-8")
        self.faults: list[TextFault] = []
        self._root: Element | None = None
        self._stack: list[Element] = []
        self._texts: list[list[str]] = []
        self._needs_xacro = False
        self._may_have_xacro = root == "robot" and (b"${" in data or b"$(" in data)
        self._parser = parser = expat.ParserCreate(encoding)
        parser.buffer_text = True
        parser.XmlDeclHandler = self._declare if encoding is None else None
        parser.StartDoctypeDeclHandler = self._doctype
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._text

    def run(self) -> Element | None:
        """Parse, and return the root if it is one that can be checked. Without a root there are faults."""
        data = self.positions.data
        if not data.removeprefix(BOM).strip():
            self._add("RD001", 0, 0, "the file is empty", "give a URDF file")
        elif data.startswith(LFS_POINTER):
            what = "this is a pointer of Git LFS, not the description"
            self._add("RD001", 0, len(LFS_POINTER), what, "git lfs pull fetches the description")
        elif b"\0" in data[:2]:  # which expat would take for UTF-16, other than `as_utf8`
            self._add("RD001", 0, 1, *_BINARY)
        elif self._parse() and (root := self._root) is not None:
            if root.tag != self.tag:
                remedy = f"give a file whose root element is <{self.tag}>"
                remedy = "give a URDF file, whose root element is <robot>" if self.tag == "robot" else remedy
                if root.tag in OTHER_FORMATS:
                    remedy = f"this is {OTHER_FORMATS[root.tag]}, and URDF is read here"
                remedy = _RUN_XACRO if self.file.endswith(".xacro") else remedy
                self._add("RD001", root.span.start, root.span.end, f"the root element is {_tag(root)}", remedy)
            elif not self._needs_xacro:
                return root
        return None

    def _parse(self) -> bool:
        try:
            self._parser.Parse(self.positions.data, True)
        except _UnreadableError:
            return False
        except expat.ExpatError as error:
            self._malformed(error.code)
            return False
        except (LookupError, ValueError) as error:
            self.positions.encoding = "utf-8"  # in which excerpts are shown
            self._add("RD001", 0, 0, f"the text cannot be decoded: {error}", "save it as UTF-8")
            return False
        return True

    def _add(self, code: str, start: int, end: int, what: str, remedy: str, *, syntax: bool = False) -> None:
        first = len(BOM) if self.positions.data.startswith(BOM) else 0
        at = self.positions.span(max(start, first), max(end, first))
        self.faults.append(TextFault(code, at, what, remedy, syntax))

    def _malformed(self, code: int) -> None:
        """Note why expat stopped, in better words than its own where there are any."""
        data, start, text = self.positions.data, max(self._parser.ErrorByteIndex, 0), expat.ErrorString(code)
        if "encoding" in text:
            self.positions.encoding = "utf-8"
        if code == _UNDEFINED_ENTITY:
            entity = _ENTITY.search(data, start)
            start, end = entity.span() if entity else (start, min(start + 1, len(data)))
            self._add("RD002", start, end, "an entity that XML does not define", _REMEDIES[text], syntax=True)
            return
        remedy = _REMEDIES.get(text, "correct the XML")
        inside = f" inside {_tag(self._stack[-1])} of line {self._stack[-1].line}" if self._stack else ""
        if self._root is None and text not in _REMEDIES:
            remedy = "the file must be XML with the root element <robot>"
        if b"\0" in data:
            (text, remedy), inside = _BINARY, ""
        elif data.startswith(_NO_BREAK_SPACE, start):
            text, remedy = "a non-breaking space (U+00A0)", "write a plain blank in its place"
        elif code == _INVALID_TOKEN:
            text, remedy = _invalid_token(data, start) or (text, remedy)
        self._add("RD001", start, min(start + 1, len(data)), text + inside, remedy, syntax=b"\0" not in data)

    def _declare(self, version: str, encoding: str | None, standalone: int) -> None:
        if encoding is not None:
            self.positions.encoding = encoding.lower()

    def _doctype(self, name: str, system: str | None, public: str | None, has_declarations: int) -> None:
        start = self.positions.data.rfind(_DOCTYPE, 0, self._parser.CurrentByteIndex + len(_DOCTYPE))
        what = "a document type with declarations" if has_declarations else "a document type"
        self._add("RD002", start, start + len(_DOCTYPE), f"{what} (<!DOCTYPE)", "delete it; URDF needs none")
        if has_declarations:
            raise _UnreadableError

    def _start(self, tag: str, values: Mapping[str, str]) -> None:
        parser, stack = self._parser, self._stack
        element = Element(tag, values, parser.CurrentLineNumber, parser.CurrentByteIndex, self.positions)
        if stack:
            stack[-1].children.append(element)
        else:
            self._root = element
        stack.append(element)
        self._texts.append([])
        if len(stack) > MAX_DEPTH:
            what = f"elements are nested more than {MAX_DEPTH} deep"
            self._add("RD001", element.start, element.start + 1, what, "URDF needs fewer than ten levels")
            raise _UnreadableError
        for name in (tag, *values):
            if ":" in name:
                self._check_prefix(element, name)
        if self._may_have_xacro and not self._in_extension():
            part = stack[1] if stack[1:] else None
            called = None if part is None or part.tag not in OWN_TAGS else part.get("name")
            owner = "" if part is None or not called else f"{part.tag} {shown(called)}: "
            for attribute, value in element.values.items():
                if unexpanded(value):
                    span = element.attributes[attribute].value_span
                    what = f"{owner}{attribute}={shown(value)} is left over from xacro"
                    self._add("RD004", span.start, span.end, what, _RUN_XACRO)

    def _end(self, tag: str) -> None:
        self._stack.pop().text = "".join(self._texts.pop())

    def _text(self, text: str) -> None:
        self._texts[-1].append(text)

    def _in_extension(self) -> bool:
        """Return whether this is inside an element that is not URDF's own (gazebo, ...) and is therefore not read."""
        return len(self._stack) > 2 and self._stack[1].tag not in OWN_TAGS

    def _check_prefix(self, element: Element, name: str) -> None:
        prefix = name.partition(":")[0]
        if prefix == "xacro":
            self._needs_xacro |= not self._in_extension()
            code, what, remedy = "RD004", f"{shown(name)} is left over from xacro", _RUN_XACRO
        else:
            declared = prefix in ("xml", "xmlns") or any(f"xmlns:{prefix}" in outer.values for outer in self._stack)
            if declared or self._in_extension():
                return
            code, what = "RD003", f"the prefix of {shown(name)} is not declared"
            remedy = f'add xmlns:{prefix}="{_NAMESPACES.get(prefix, "...")}" to <robot>'
        start = element.start + 1 if name == element.tag else element.attributes[name].span.start
        self._add(code, start, start + len(name.encode()), what, remedy)


def _tag(element: Element) -> str:
    return f"<{element.tag if len(element.tag) <= 60 else element.tag[:60] + '...'}>"


def _invalid_token(data: bytes, start: int) -> tuple[str, str] | None:
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
