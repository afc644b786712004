"""Edits of bytes: which go together, and the text that they make."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

from robodyn.checks.rule import Edit, Finding, Fix


def together(findings: Iterable[Finding], safe: bool) -> list[tuple[Finding, Fix]]:
    """Fixes of one kind that do not touch each other: the earlier in the text first, then the lower code.

    A fix is taken with all its edits or not at all.
    """
    offered = [(finding, finding.fix) for finding in findings if finding.fix is not None and finding.fix.safe is safe]
    offered.sort(key=lambda pair: (min(edit.start for edit in pair[1].edits), pair[0].code, pair[0].start))
    chosen: list[tuple[Finding, Fix]] = []
    taken: list[Edit] = []
    for finding, fix in offered:
        edits = sorted(fix.edits, key=lambda edit: edit.start)
        alone = not any(_touch(a, b) for a, b in pairwise(edits))
        if alone and not any(_touch(edit, other) for edit in edits for other in taken):
            chosen.append((finding, fix))
            taken += edits
    return chosen


def edited(data: bytes, fixes: Iterable[Fix], encoding: str) -> bytes:
    """The text with the edits made; what the encoding lacks is written as a character reference."""
    parts, place = [], 0
    for edit in sorted((edit for fix in fixes for edit in fix.edits), key=lambda edit: edit.start):
        parts += [data[place : edit.start], edit.text.encode(encoding, "xmlcharrefreplace")]
        place = edit.end
    return b"".join([*parts, data[place:]])


def _touch(a: Edit, b: Edit) -> bool:
    """Whether they overlap, or one inserts at a border of the other."""
    if a.start == a.end or b.start == b.end:
        return a.start <= b.end and b.start <= a.end
    return a.start < b.end and b.start < a.end
