"""Waivers: comments in the file that allow a finding at one element, with a reason.

    <!-- robodyn: allow RD208 the maker gives no tensor, see issue 52 -->
    <link name="cover"> ... </link>

A comment behind a tag, on the same line, is about that element, any other about the next element that begins after it;
in both cases about everything in the element. Several codes stand between commas. Without a reason, or with a code that
no rule has, a waiver is not in force, and RD008 says so; RD009 reports one that has nothing to waive.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robodyn.checks.context import Context
from robodyn.checks.rule import Finding
from robodyn.robot.urdf.document import Document, Span
from robodyn.support.wording import alternatives, shown

OWN = ("RD008", "RD009")  # the rules about waivers, which cannot be waived
EXAMPLE = "<!-- robodyn: allow RD208 why this is so -->"
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
_WAIVER = re.compile(rb"<!--\s*robodyn:(.*?)-->", re.DOTALL)
_ALLOW = re.compile(r"allow\s+(\w+(?:\s*,\s*\w+)*)\b[\s:;,.-]*(.*)", re.DOTALL)
_REST = re.compile(rb"[ \t]*(?:\r\n|\r|\n)")
_IN_LINE = re.compile(rb"[^\r\n]")
_NONE = np.array([], int)
_END_TAG = re.compile(rb"</([^ \t\r\n>]+)[ \t\r\n]*>\s*")


@dataclass(frozen=True, slots=True, eq=False)
class Waiver:
    """A comment that is meant as a waiver, with its text after `robodyn:`; without codes where it is not understood.
    The bytes `erased` go when the waiver goes. From `start` to `end` are the element that it is about and what follows
    up to the next one outside that; equal without one."""

    at: Span
    text: str
    codes: tuple[str, ...]
    reason: str
    erased: tuple[int, int]
    start: int
    end: int

    def in_force(self, known: Collection[str]) -> bool:
        return bool(self.codes and self.reason) and set(self.codes) <= set(known) - set(OWN)

    def problem(self, known: Collection[str]) -> tuple[str, str]:
        """What is wrong with a waiver that is not in force, and what to do."""
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
    reading, found = context.reading, list[Waiver]()
    if reading.robot is None or b"robodyn:" not in reading.data:
        return ()
    comments = list(_WAIVER.finditer(reading.data))
    for comment, place in zip(comments, _places(reading, [one.start() for one in comments]), strict=True):
        text = " ".join(comment.group(1).decode(reading.encoding).split())
        allow = _ALLOW.fullmatch(text)
        codes = tuple(code.strip() for code in allow.group(1).split(",")) if allow else ()
        at, start = reading.root.positions.span(*comment.span()), comment.start()
        while reading.data[start - 1 : start] in (b" ", b"\t"):
            start -= 1
        rest = _REST.match(reading.data, at.end)
        alone = rest is not None and reading.data[start - 1 : start] in (b"\n", b"\r")
        erased = start, rest.end() if alone and rest else at.end
        found.append(Waiver(at, text, codes, allow.group(2) if allow else "", erased, *place))
    return tuple(found)


def waived(
    reading: Document, findings: Iterable[Finding], given: Sequence[Waiver]
) -> tuple[list[Finding], list[tuple[Waiver, str]]]:
    """Return the findings that no waiver allows, and the codes of each waiver for which there is nothing to allow. A
    finding in another file is waived as if it were at the robot's start tag."""
    starts, ends = (np.array([getattr(waiver, end) for waiver in given]) for end in ("start", "end"))
    allowing: dict[str, list[int]] = {}
    for k, waiver in enumerate(given):
        for code in waiver.codes:
            allowing.setdefault(code, []).append(k)
    numbers = {code: np.array(found) for code, found in allowing.items()}
    used = {code: np.zeros(len(given), bool) for code in allowing}
    kept = []
    for finding in findings:
        start = finding.start if finding.file == reading.file else reading.root.start
        of_code = numbers.get(finding.code, _NONE)
        by = of_code[(starts[of_code] <= start) & (start < ends[of_code])]
        if by.size:
            used[finding.code][by] = True
        else:
            kept.append(finding)
    codes = ((k, waiver, code) for k, waiver in enumerate(given) for code in waiver.codes)
    return kept, [(waiver, code) for k, waiver, code in codes if not used[code][k]]


def _places(reading: Document, comments: Iterable[int]) -> Iterator[tuple[int, int]]:
    """Yield for each comment, by its start, the bytes from the element that it is about to the next element outside
    it; what is before one on its line is looked at once."""
    blank = _COMMENT.sub(lambda comment: _IN_LINE.sub(b" ", comment[0]), reading.data)
    text, elements, with_tag = blank.replace(b"\r", b"\n"), list(reading.root.walk()), dict[str, list[int]]()
    starts = [element.start for element in elements]
    for k, element in enumerate(elements):
        with_tag.setdefault(element.tag, []).append(k)
    after = {id(elements[0]): len(blank)}  # where the next element begins that is not within this one
    for element in elements:
        following = [*(child.start for child in element.children[1:]), after[id(element)]]
        after.update(zip(map(id, element.children), following, strict=False))
    seen, behind_a_tag, closed = 0, False, None
    for comment in comments:
        _, line, written = text[seen:comment].rpartition(b"\n")
        seen, written = comment, written.rstrip()
        if line or written:
            behind_a_tag, closed = bool(written), _END_TAG.fullmatch(written[written.rfind(b"<") :])
        first = k = bisect_left(starts, comment)
        if behind_a_tag:
            of_tag = range(first) if closed is None else with_tag.get(closed.group(1).decode("latin-1"), ())
            before = bisect_left(of_tag, first)
            k = of_tag[before - 1] if before else first
        yield (len(text), len(text)) if k == len(starts) else (starts[k], after[id(elements[k])])
