"""Elements out of expat's events; what no URDF may contain is refused as soon as it appears."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NoReturn
from xml.parsers import expat

from robodyn.errors import DescriptionError
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.source_positions import Places
from robodyn.support.wording import shown

MAX_DEPTH = 200
RUN_XACRO = "name it FILE.xacro, and it is expanded first"
_OWN_TAGS = frozenset({"link", "joint", "material", "transmission"})


class Builder:
    """One parse: `parser` feeds it, `root` is the result, `stack` the elements that are still open."""

    def __init__(self, file: str, data: bytes, encoding: str | None) -> None:
        self.file = file
        self.places = Places(data, "utf-8")
        self.root: Element | None = None
        self.stack: list[Element] = []
        self._texts: list[list[str]] = []
        self._may_have_xacro = b"${" in data or b"$(" in data
        self.parser = parser = expat.ParserCreate(encoding)
        parser.buffer_text = True
        if encoding is None:
            parser.XmlDeclHandler = self._declare
        parser.StartDoctypeDeclHandler = self._refuse_doctype
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._text

    def _declare(self, version: str, encoding: str | None, standalone: int) -> None:
        if encoding is not None:
            self.places.encoding = encoding.lower()

    def _refuse_doctype(self, *declaration: object) -> None:
        self._fail("a document type declaration (<!DOCTYPE, entities) is never read", "delete it; URDF needs none")

    def _start(self, tag: str, values: Mapping[str, str]) -> None:
        parser, stack = self.parser, self.stack
        element = Element(tag, values, parser.CurrentLineNumber, parser.CurrentByteIndex, self.places)
        if stack:
            stack[-1].children.append(element)
        else:
            self.root = element
        stack.append(element)
        self._texts.append([])
        if len(stack) > MAX_DEPTH:
            self._fail(f"elements are nested more than {MAX_DEPTH} deep", "URDF needs fewer than ten levels")
        for name in (tag, *values):
            if ":" in name:
                self._check_prefix(name)
        if self._may_have_xacro:
            self._check_expressions(values)

    def _end(self, tag: str) -> None:
        self.stack.pop().text = "".join(self._texts.pop())

    def _text(self, text: str) -> None:
        self._texts[-1].append(text)

    def _in_extension(self) -> bool:
        """Inside an element that is not URDF's own (gazebo, ros2_control, ...) and is therefore not read."""
        return len(self.stack) > 2 and self.stack[1].tag not in _OWN_TAGS

    def _check_prefix(self, name: str) -> None:
        prefix = name.partition(":")[0]
        if prefix == "xacro":
            self._fail(f"{shown(name)} is left over from xacro", RUN_XACRO)
        if prefix in ("xml", "xmlns") or self._in_extension():
            return
        if not any(f"xmlns:{prefix}" in element.values for element in self.stack):
            self._fail(f"the prefix of {shown(name)} is not declared", f'add xmlns:{prefix}="..." to <robot>')

    def _check_expressions(self, values: Mapping[str, str]) -> None:
        if self._in_extension():
            return
        for name, value in values.items():
            if "${" in value or "$(" in value:
                line = self.stack[-1].attributes[name].span.line
                self._fail(f"{name}={shown(value)} is left over from xacro", RUN_XACRO, line)

    def _fail(self, what: str, remedy: str, line: int | None = None) -> NoReturn:
        raise DescriptionError(what, remedy=remedy, file=self.file, line=line or self.parser.CurrentLineNumber)
