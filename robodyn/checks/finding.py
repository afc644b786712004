"""What a check finds: a fault of a rule at its place, one or several of which make a finding."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

from robodyn.robot.urdf.document import Document
from robodyn.robot.urdf.edits import Edit
from robodyn.robot.urdf.elements import BOM, Span
from robodyn.robot.urdf.view import Subject


class Severity(Enum):
    """ERROR fails the check, WARNING fails it with `--strict`, NOTE is a remark."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"

    def reaches(self, least: Severity) -> bool:
        """Return whether it is at least as severe as another."""
        return _ORDER.index(self) <= _ORDER.index(least)


_ORDER = tuple(Severity)
"""The most severe first."""


@dataclass(frozen=True, slots=True)
class Fix:
    """The one right correction: `what` it does, its edits, and whether it leaves the dynamics as they are."""

    what: str
    edits: tuple[Edit, ...]
    safe: bool


@dataclass(frozen=True, slots=True)
class Excerpt:
    """The line of the source around a finding, cut to a readable length, and where in it the finding stands."""

    text: str
    start: int
    length: int


@dataclass(frozen=True, slots=True)
class Finding:
    """A fault with its rule and its place; what the reports show.

    `message` names the subject; `line` and `column` (in characters) count from 1, `start` and `end` are bytes.
    `kind` is the message without subject, names and numbers: what findings share that one cause explains. `others` are
    the further places of the same cause in the file, in their order (see `robodyn.checks.groups`). `description` is the
    file that was checked, where `file` is another one: macros that it includes, or its SRDF.
    """

    code: str
    name: str
    severity: Severity
    file: str
    line: int
    column: int
    start: int
    end: int
    subject: Subject | None
    message: str
    remedy: str
    measured: float | None
    bound: float | None
    cause: str | None
    fix: Fix | None
    excerpt: Excerpt
    kind: str = ""
    others: tuple[Finding, ...] = ()
    description: str | None = None

    @property
    def checked(self) -> str:
        """The file that was checked."""
        return self.description or self.file

    @property
    def what(self) -> str:
        """The message without the subject."""
        subject = self.subject
        return self.message if subject is None else self.message.removeprefix(f"{subject.words}: ")

    @property
    def places(self) -> tuple[Finding, ...]:
        """Every place by itself, the first included."""
        return (replace(self, others=()), *self.others) if self.others else (self,)


_BEFORE, _AFTER = 60, 60
"""Bytes that are shown before and after a finding, at most; its first `_AFTER` count."""


def excerpt(reading: Document, at: Span) -> Excerpt:
    """Return the line in which the span begins, without its indent, and cut where it is long."""
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
    """Return the place after the last line end in [first, last), or `first`."""
    return max(data.rfind(b"\n", first, last), data.rfind(b"\r", first, last), first - 1) + 1
