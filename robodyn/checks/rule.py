"""What a check is made of: rules, what they are given, and what they find.

A rule is one function in a file of `robodyn/checks/rules/`, that of its family, and nothing else is needed to add one.
Its name is the rule's, its docstring the documentation. It is given a `Context`, yields one `Fault` for each thing that
is wrong, and never raises. What it may rely on is its `stage`:

    TEXT      `context.reading`: the bytes, and what is wrong with them as XML
    DOCUMENT  `context.view`: links, joints and numbers as far as they can be read; names may lead nowhere
    TREE      `context.tree` as well: one tree, one root, rigid groups; every name is unique and leads somewhere
    MODEL     `context.model` as well

A rule runs only where its stage is reached, so that one defect gives no second error. Within its stage a rule is silent
about what another rule reports: a number that cannot be read is None in the view, and is RD007's alone.
Whatever is costly and serves several rules is a function of the context, called by `context.once(function)`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from enum import Enum, IntEnum
from inspect import cleandoc

from robodyn.checks.context import Context
from robodyn.robot.urdf.document import BOM, Document, Element, Span
from robodyn.robot.urdf.edits import Edit
from robodyn.robot.urdf.view import Subject

_BEFORE, _AFTER = 60, 60  # bytes that are shown before and after a finding, at most; its first `_AFTER` count
__all__ = ["Context", "Edit"]
HERE = Subject("", "")  # the link or joint in which a fault is


class Severity(Enum):
    """ERROR fails the check, WARNING fails it with `--strict`, NOTE is a remark."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"

    def reaches(self, least: Severity) -> bool:
        return _ORDER.index(self) <= _ORDER.index(least)


_ORDER = ERROR, WARNING, NOTE = tuple(Severity)  # the most severe first


@dataclass(frozen=True, slots=True)
class Fix:
    """The one right correction: `what` it does, its edits, and whether it leaves the dynamics as they are."""

    what: str
    edits: tuple[Edit, ...]
    safe: bool


@dataclass(frozen=True, slots=True)
class Excerpt:
    """The line around a finding, cut to a readable length, and where in it the finding stands."""

    text: str
    start: int
    length: int


@dataclass(frozen=True, slots=True)
class Finding:
    """A fault with its rule and its place; what the reports show. `message` names the subject; `line` and `column` (in
    characters) count from 1, `start` and `end` are bytes. `kind` is the message without subject, names and numbers:
    what findings share that one cause explains. `others` are the further places of the same cause in the file, in their
    order, and then those of the same finding in other files (see `robodyn.checks.groups`). `description` is the file
    that was checked, where `file` is another one: macros that it includes, or its SRDF. `robots` are the files that
    were checked and share it, where xacro files are among them."""

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
    robots: tuple[str, ...] = ()

    @property
    def checked(self) -> str:
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


def excerpt(reading: Document, at: Span) -> Excerpt:
    """Return the line in which the span begins, without its indent, and cut where it is long."""
    data = reading.data
    last = min(at.start + _AFTER, len(data))
    first = max(at.start - _BEFORE, len(BOM) * data.startswith(BOM))
    start = max(data.rfind(b"\n", first, at.start) + 1, data.rfind(b"\r", first, at.start) + 1, first)
    ends = (data.find(newline, at.start, last) for newline in (b"\n", b"\r"))
    end = min((found for found in ends if found >= 0), default=last)
    before = data[start : at.start].decode(reading.encoding, "ignore").lstrip()
    text = data[at.start : end].decode(reading.encoding, "ignore").rstrip()
    within = data[at.start : min(at.end, end)].decode(reading.encoding, "ignore")
    shown = (before + text).replace("\t", " ")
    return Excerpt(shown, len(before), max(min(len(within), len(text)), 1))


class Stage(IntEnum):
    """How far the reading must have come for a rule to run; see above."""

    TEXT = 0
    DOCUMENT = 1
    TREE = 2
    MODEL = 3


TREE, MODEL = Stage.TREE, Stage.MODEL


@dataclass(frozen=True, slots=True)
class Fault:
    """What a check has found."""

    at: Span  # the attribute (or the start tag) at fault
    what: str  # what is wrong, with the numbers, without the subject: "the mass is -1 kg, not positive"
    remedy: str  # what to do about it
    measured: float | None = None  # in SI units, as the next
    bound: float | None = None  # what it must keep to
    subject: Subject | None = HERE  # if it is not the link or joint that `at` is in; None for the file as a whole
    severity: Severity | None = None  # where it is not the rule's
    cause: str | None = None  # why it is so, where that can be established
    fix: Fix | None = None  # where one edit is uniquely right
    kind: str | None = None  # what others of the same cause have in common; by default `what` without names and numbers
    document: Document | None = None  # the file that `at` is in, if it is not the description


Faults = Iterable[Fault]


def namesakes(elements: Iterable[Element]) -> Iterator[tuple[Element, Element]]:
    """Yield the elements whose name another one before them has, each with the first of that name."""
    first: dict[str, Element] = {}
    for element in elements:
        name = element.get("name")
        if name and first.setdefault(name, element) is not element:
            yield element, first[name]


def subject_of(element: Element) -> Subject:
    return Subject(element.tag, element.get("name") or "")


def text_faults(context: Context, code: str) -> Faults:
    """Return what the reader of XML has noted for a rule."""
    return [Fault(found.at, found.what, found.remedy, subject=None) for found in context.reading.found(code)]


@dataclass(frozen=True, slots=True)
class Rule:
    """One rule with its documentation; `bad` and `good` are whole descriptions, and tests run both. Findings below its
    `default` are shown where the rule or ALL is selected."""

    code: str
    name: str
    severity: Severity
    stage: Stage
    summary: str
    explanation: str
    bad: str
    good: str
    check: Callable[[Context], Faults]
    default: Severity = Severity.WARNING
    explains: tuple[str, ...] = ()  # codes whose finding about the same link or joint is the same defect

    @property
    def in_default(self) -> bool:
        return self.severity.reaches(self.default)


def rule(
    code: str,
    severity: Severity,
    stage: Stage = Stage.DOCUMENT,
    *,
    good: str,
    bad: str | tuple[str, str],
    explanation: str = "",
    default: Severity = Severity.WARNING,
    explains: tuple[str, ...] = (),
) -> Callable[[Callable[[Context], Faults]], Rule]:
    """Make the decorated function a rule of its name: `mass_not_positive` is mass-not-positive.

    Its docstring is the summary, one sentence, and after a blank line the explanation, unless this is given. `good` and
    `bad` are descriptions; a pair is a piece of the good one and what stands in its place in the bad one. `default` is
    ERROR for a rule whose warnings are a matter of taste or of one program, NOTE where remarks matter."""
    wrong = bad if isinstance(bad, str) else good.replace(*bad)

    def decorate(check: Callable[[Context], Faults]) -> Rule:
        name = check.__name__.replace("_", "-")
        summary, _, text = cleandoc(check.__doc__ or "").partition("\n\n")
        return Rule(code, name, severity, stage, summary, explanation or text, wrong, good, check, default, explains)

    return decorate
