"""The line of the source around a finding."""

from __future__ import annotations

from robodyn.checks.reading import Reading
from robodyn.checks.rule import Excerpt
from robodyn.robot.urdf.source_positions import BOM, Span

_BEFORE, _AFTER = 60, 60
"""Bytes that are shown before and after a finding, at most; its first `_AFTER` count."""


def excerpt(reading: Reading, at: Span) -> Excerpt:
    """The line in which the span begins, without its indent, and cut where it is long."""
    data = reading.data
    last = min(at.start + _AFTER, len(data))
    start = max(_after_newline(data, max(at.start - _BEFORE, 0), at.start), len(BOM) * data.startswith(BOM))
    end = min(
        (found for found in (data.find(b"\n", at.start, last), data.find(b"\r", at.start, last)) if found >= 0),
        default=last,
    )
    before = data[start : at.start].decode(reading.encoding, "ignore").lstrip()
    text = data[at.start : end].decode(reading.encoding, "ignore").rstrip()
    within = data[at.start : min(at.end, end)].decode(reading.encoding, "ignore")
    shown = (before + text).replace("\t", " ")
    return Excerpt(shown, len(before), max(min(len(within), len(text)), 1))


def _after_newline(data: bytes, first: int, last: int) -> int:
    """The place after the last line end in [first, last), or `first`."""
    return max(data.rfind(b"\n", first, last), data.rfind(b"\r", first, last), first - 1) + 1
