"""Waivers: comments in the file that allow a finding at one element, with a reason.

    <!-- robodyn: allow RD208 the maker gives no tensor, see issue 52 -->
    <link name="cover"> ... </link>

A comment behind a tag, on the same line, is about that element, any other about the next element that begins after it;
in both cases about everything in the element. Several codes stand between commas. Without a reason, or with a code that
no rule has, a waiver is not in force, and RD008 says so; RD009 reports one that has nothing to waive.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass

from robodyn.checks.context import Context
from robodyn.checks.rule import Finding
from robodyn.robot.urdf.document import Document
from robodyn.robot.urdf.elements import Element, Span
from robodyn.support.wording import alternatives, shown

OWN = ("RD008", "RD009")
"""The rules about waivers, which cannot be waived."""
EXAMPLE = "<!-- robodyn: allow RD208 why this is so -->"
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
_WAIVER = re.compile(rb"<!--\s*robodyn:(.*?)-->", re.DOTALL)
_ALLOW = re.compile(r"allow\s+(\w+(?:\s*,\s*\w+)*)\b[\s:;,.-]*(.*)", re.DOTALL)
_REST = re.compile(rb"[ \t]*(?:\r\n|\r|\n)")
_END_TAG = re.compile(rb"</([^ \t\r\n>]+)[ \t\r\n]*>\s*")


@dataclass(frozen=True, slots=True)
class Waiver:
    """A comment that is meant as a waiver.

    Attributes:
        at: the comment.
        text: what it says after `robodyn:`.
        codes: which findings it allows; none where it is not understood.
        reason: why; empty where there is none.
        erased: bytes that go when the waiver goes: the comment, with its line where nothing else is on that.
        start, end: bytes from the element that it is about to the next one outside that; equal where there is none.
    """

    at: Span
    text: str
    codes: tuple[str, ...]
    reason: str
    erased: tuple[int, int]
    start: int
    end: int

    def in_force(self, known: Collection[str]) -> bool:
        return bool(self.codes and self.reason) and set(self.codes) <= set(known) - set(OWN)

    def allows(self, code: str, start: int) -> bool:
        """Return whether a finding of a rule at this byte is allowed."""
        return code in self.codes and self.start <= start < self.end

    def problem(self, known: Collection[str]) -> tuple[str, str]:
        """Return what is wrong with a waiver that is not in force, and what to do."""
        if not self.codes:
            return f"the comment {shown('robodyn: ' + self.text)} is not understood", f"write {EXAMPLE}"
        for code in self.codes:
            if code in OWN:
                return f"{code} cannot be waived", "delete the waiver"
            if code not in known:
                return f"the waiver names {shown(code)}, which no rule has", alternatives(code.upper(), known, "rules")
        return f"the waiver of {', '.join(self.codes)} gives no reason", f"write {EXAMPLE}"


def waivers(context: Context) -> tuple[Waiver, ...]:
    """Return the waivers of a file, in their order; none where the file could not be read to its end."""
    return tuple(_waivers(context.reading))


def waived(
    reading: Document, findings: Iterable[Finding], given: Sequence[Waiver]
) -> tuple[list[Finding], list[tuple[Waiver, str]]]:
    """Return the findings that no waiver allows, and the codes of each waiver for which there is nothing to allow.

    A finding in another file is waived as if it were at the robot's start tag.
    """
    kept, used = [], set()
    for finding in findings:
        start = finding.start if finding.file == reading.file else reading.root.start
        by = {(k, finding.code) for k, waiver in enumerate(given) if waiver.allows(finding.code, start)}
        used |= by
        if not by:
            kept.append(finding)
    codes = ((k, waiver, code) for k, waiver in enumerate(given) for code in waiver.codes)
    return kept, [(waiver, code) for k, waiver, code in codes if (k, code) not in used]


def _waivers(reading: Document) -> Iterator[Waiver]:
    if reading.robot is None or b"robodyn:" not in reading.data:
        return
    elements = list(_downward(reading.root))
    for comment in _WAIVER.finditer(reading.data):
        text = " ".join(comment.group(1).decode(reading.encoding).split())
        allow = _ALLOW.fullmatch(text)
        codes = tuple(code.strip() for code in allow.group(1).split(",")) if allow else ()
        at = reading.root.positions.span(*comment.span())
        reason = allow.group(2) if allow else ""
        yield Waiver(at, text, codes, reason, _erased(reading.data, at), *_about(reading.data, at, elements))


def _downward(root: Element) -> Iterator[tuple[int, Element]]:
    """Yield the depth and the element, in the order of the file."""
    waiting = [(0, root)]
    while waiting:
        depth, element = waiting.pop()
        yield depth, element
        waiting += [(depth + 1, child) for child in reversed(element.children)]


def _erased(data: bytes, at: Span) -> tuple[int, int]:
    start = len(data[: at.start].rstrip(b" \t"))
    rest = _REST.match(data, at.end)
    alone = rest is not None and data[start - 1 : start] in (b"\n", b"\r")
    return start, rest.end() if alone and rest else at.end


def _about(data: bytes, at: Span, elements: list[tuple[int, Element]]) -> tuple[int, int]:
    """Return the bytes from the element that a comment is about to the next element outside it."""
    line = max(data.rfind(b"\n", 0, at.start), data.rfind(b"\r", 0, at.start)) + 1
    before = _COMMENT.sub(b"", data[line : at.start])
    first = sum(element.start < at.start for _, element in elements)
    if not before.strip():
        k = first
    else:
        closed = _END_TAG.fullmatch(before, before.rfind(b"<"))
        tags = {closed.group(1).decode("latin-1")} if closed else None
        k = next((i for i in range(first - 1, -1, -1) if tags is None or elements[i][1].tag in tags), first)
    if k == len(elements):
        return len(data), len(data)
    depth, element = elements[k]
    end = next((other.start for level, other in elements[k + 1 :] if level <= depth), len(data))
    return element.start, end
