"""Elements and faults out of expat's events.

Nothing here raises: what is wrong with a file as XML is data, and whoever reads decides what to do about it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from xml.parsers import expat

from robodyn.errors import DescriptionError
from robodyn.robot.urdf.elements import BOM, Element, SourcePositions, Span
from robodyn.robot.urdf.malformed import BINARY, malformed
from robodyn.support.input_file import LFS_POINTER
from robodyn.support.wording import shown

MAX_DEPTH = 200
RUN_XACRO = "name it FILE.xacro, and it is expanded first"
OWN_TAGS = frozenset({"link", "joint", "material", "transmission"})
"""Elements of the robot whose content is URDF's; all others belong to other tools and are not read."""
_DOCTYPE = b"<!DOCTYPE"
_NAMESPACES = {"drake": "http://drake.mit.edu"}
_KINDS = {"sdf": "this is SDF; convert it to URDF", "mujoco": "this is MJCF; convert it to URDF"}


@dataclass(frozen=True, slots=True)
class TextFault:
    """Something wrong with the file as XML: what rule `code` says of it, and the error that strict reading raises."""

    code: str
    at: Span
    what: str
    remedy: str
    error: DescriptionError


class _UnreadableError(Exception):
    """Nothing after this place can be read."""


class Reader:
    """One parse: expat's events become elements and faults, both in the order in which they are met."""

    def __init__(self, file: str, data: bytes, encoding: str | None) -> None:
        self.file = file
        self.positions = SourcePositions(data, "utf-8")
        self.faults: list[TextFault] = []
        self._root: Element | None = None
        self._stack: list[Element] = []
        self._texts: list[list[str]] = []
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
        """Parse, and return the root if it is one that can be checked. Without a root there are faults."""
        if not self.positions.data.removeprefix(BOM).strip():
            self._add("RD001", 0, 0, "the file is empty", "give a URDF file")
        elif self.positions.data.startswith(LFS_POINTER):
            what = "this is a pointer of Git LFS, not the description"
            self._add("RD001", 0, len(LFS_POINTER), what, "git lfs pull fetches the description")
        elif b"\0" in self.positions.data[:2]:  # which expat would take for UTF-16, other than `as_utf8`
            self._add("RD001", 0, 1, *BINARY)
        elif self._parse() and self._root is not None and self._root.tag != "robot":
            self._wrong_root(self._root)
        elif self._whole and not self._unexpanded:
            return self._root
        return None

    def _parse(self) -> bool:
        """Return whether the file could be read to its end."""
        try:
            self._parser.Parse(self.positions.data, True)
            self._whole = True
        except _UnreadableError:
            pass
        except expat.ExpatError as error:
            self._malformed(error)
        except (LookupError, ValueError) as error:
            self.positions.encoding = "utf-8"  # in which excerpts are shown
            remedy = "save it as UTF-8"
            strict = f"cannot decode the text: {error}", remedy
            self._add("RD001", 0, 0, f"the text cannot be decoded: {error}", remedy, strict=strict)
        return self._whole

    def _add(
        self,
        code: str,
        start: int,
        end: int,
        what: str,
        remedy: str,
        *,
        line: int | None = None,
        strict: tuple[str, str | None] | None = None,
    ) -> None:
        """Note a fault; `line`, and what is wrong and the remedy (`strict`), are the error's where they are others."""
        first = len(BOM) if self.positions.data.startswith(BOM) else 0
        at = self.positions.span(max(start, first), max(end, first))
        wrong, do = strict or (what, remedy)
        error = DescriptionError(wrong, remedy=do, file=self.file, line=line or at.line)
        self.faults.append(TextFault(code, at, what, remedy, error))

    def _wrong_root(self, root: Element) -> None:
        span, other = root.span, _KINDS.get(root.tag)
        remedy = other or "give a URDF file, whose root element is <robot>"
        do = other or (RUN_XACRO if self.file.endswith(".xacro") else "give a URDF file")
        strict = f"the root element is {shown(root.tag)}, not 'robot'", do
        self._add(
            "RD001", span.start, span.end, f"the root element is <{root.tag}>", remedy, line=root.line, strict=strict
        )

    def _malformed(self, error: expat.ExpatError) -> None:
        inside = self._stack[-1] if self._stack else None
        found = malformed(error.code, self.positions.data, max(self._parser.ErrorByteIndex, 0), inside, self._root)
        if "encoding" in expat.ErrorString(error.code):
            self.positions.encoding = "utf-8"
        self._add(*found[:5], line=error.lineno, strict=found.strict)

    def _declare(self, version: str, encoding: str | None, standalone: int) -> None:
        if encoding is not None:
            self.positions.encoding = encoding.lower()

    def _doctype(self, name: str, system: str | None, public: str | None, has_declarations: int) -> None:
        start = self.positions.data.rfind(_DOCTYPE, 0, self._parser.CurrentByteIndex + len(_DOCTYPE))
        what = "a document type with declarations" if has_declarations else "a document type"
        remedy = "delete it; URDF needs none"
        strict = "a document type declaration (<!DOCTYPE, entities) is never read", remedy
        line = self._parser.CurrentLineNumber
        self._add("RD002", start, start + len(_DOCTYPE), f"{what} (<!DOCTYPE)", remedy, line=line, strict=strict)
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
            self._check_expressions(element)

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
            self._unexpanded |= not self._in_extension()
            code, what, remedy = "RD004", f"{shown(name)} is left over from xacro", RUN_XACRO
        else:
            declared = prefix in ("xml", "xmlns") or any(f"xmlns:{prefix}" in outer.values for outer in self._stack)
            if declared or self._in_extension():
                return
            what = f"the prefix of {shown(name)} is not declared"
            remedy = f'add xmlns:{prefix}="{_NAMESPACES.get(prefix, "...")}" to <robot>'
            code = "RD003"
        start = element.start + 1 if name == element.tag else element.attributes[name].span.start
        self._add(code, start, start + len(name.encode()), what, remedy, line=element.line)

    def _part(self) -> str:
        """Return the link or joint that is being read, with a colon; nothing outside of them."""
        part = self._stack[1] if self._stack[1:] else None
        name = None if part is None or part.tag not in OWN_TAGS else part.get("name")
        return "" if part is None or not name else f"{part.tag} {shown(name)}: "

    def _check_expressions(self, element: Element) -> None:
        for name, value in element.values.items():
            if unexpanded(value):
                whole, span = element.attributes[name].span, element.attributes[name].value_span
                what = f"{self._part()}{name}={shown(value)} is left over from xacro"
                self._add("RD004", span.start, span.end, what, RUN_XACRO, line=whole.line)


def unexpanded(text: str) -> bool:
    """Return whether there is an expression in it that xacro should have replaced."""
    return "${" in text or "$(" in text
