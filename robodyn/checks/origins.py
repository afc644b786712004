"""Findings in expanded text, at the place in the xacro file that made it."""

from __future__ import annotations

from bisect import bisect_right
from collections import defaultdict
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

from robodyn.checks.rule import Finding, excerpt
from robodyn.robot.urdf.document import Document
from robodyn.robot.urdf.elements import Element, SourcePositions, Span
from robodyn.robot.urdf.packages import EXPANDED
from robodyn.support.input_file import read_input

if TYPE_CHECKING:
    from robodyn.robot.urdf.xacro import Expansion


class Origins:
    """Where the elements of an expanded description were written."""

    def __init__(self, reading: Document, expansion: Expansion) -> None:
        self._reading = reading
        self._expansion = expansion
        elements = [] if reading.robot is None else list(reading.root.walk())
        self._elements = elements if len(elements) == len(expansion.places) else []
        self._starts = [element.start for element in self._elements]
        self._read = cache(lambda file: Document(file, read_input(file), "utf-8", (), None))

    def located(self, finding: Finding) -> Finding:
        """Return the finding at the attribute, or the start tag, that it comes from: of a macro, in the macro.

        A fix of the expanded text is none of that. What cannot be traced back is at the beginning of the file, and the
        message says where in the expanded text it is; what is in another file, as an SRDF, stays there.
        """
        described = self._reading.file.removesuffix(EXPANDED)
        if finding.file != self._reading.file:
            return replace(finding, description=described)
        k = bisect_right(self._starts, finding.start) - 1
        number, start = self._expansion.places[max(k, 0)]
        source, message = self._read(self._expansion.files[number]), finding.message
        if k < 0:
            at = SourcePositions(source.data, source.encoding).span(0, 0)
            message += f" (line {finding.line} of what `xacro {source.file}` prints)"
        else:
            at = _in_source(self._elements[k], finding, source, start)
        return replace(
            finding,
            message=message,
            file=source.file,
            description=None if source.file == described else described,
            line=at.line,
            column=at.column,
            start=at.start,
            end=at.end,
            fix=None,
            excerpt=excerpt(source, at),
        )


def _in_source(element: Element, finding: Finding, source: Document, start: int) -> Span:
    written = Element("", defaultdict(str), 0, start, SourcePositions(source.data, source.encoding))
    for name, attribute in element.attributes.items():
        if attribute.span.start <= finding.start <= attribute.span.end and name in written.attributes:
            whole = finding.start < attribute.value_span.start
            return written.attributes[name].span if whole else written.attributes[name].value_span
    return written.span
