"""What a check is made of: rules, what they are given, and what they find.

A rule is one file in `robodyn/checks/rules/`, named after its code, and nothing else is needed to add one. Its
docstring is its documentation, and its `check`, which `@rule` makes the rule, is a generator: it is given a `Context`,
yields one `Fault` for each thing that is wrong, and never raises. What it may rely on is its `stage`:

    TEXT      `context.reading`: the bytes, and what is wrong with them as XML
    DOCUMENT  `context.view`: links, joints and numbers as far as they can be read; names may lead nowhere
    TREE      `context.tree` as well: one tree, one root, rigid groups; every name is unique and leads somewhere
    MODEL     `context.model` as well

A rule runs only where its stage is reached, so that one defect gives no second error. Within its stage a rule is silent
about what another rule reports: a number that cannot be read is None in the view, and is RD007's alone.
Whatever is costly and serves several rules is a function of the context, called by `context.once(function)`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import IntEnum

from robodyn.checks.context import Context
from robodyn.checks.finding import Excerpt, Finding, Fix, Severity, excerpt
from robodyn.robot.urdf.document import Document
from robodyn.robot.urdf.edits import Edit
from robodyn.robot.urdf.elements import Span
from robodyn.robot.urdf.view import Subject

__all__ = [
    "HERE",
    "Context",
    "Edit",
    "Excerpt",
    "Fault",
    "Faults",
    "Finding",
    "Fix",
    "Rule",
    "Severity",
    "Stage",
    "excerpt",
    "rule",
    "text_faults",
]


class Stage(IntEnum):
    """How far the reading must have come for a rule to run; see above."""

    TEXT = 0
    DOCUMENT = 1
    TREE = 2
    MODEL = 3


HERE = Subject("", "")
"""The link or joint in which a fault is."""


@dataclass(frozen=True, slots=True)
class Fault:
    """What a check has found.

    Attributes:
        at: the attribute (or the start tag) at fault.
        what: what is wrong, with the numbers, without the subject: "the mass is -1 kg, not positive".
        remedy: what to do about it.
        measured, bound: the number and what it must keep to, in SI units.
        subject: what it is about, if it is not the link or joint that `at` is in; None for the file as a whole.
        severity: where it is not the rule's.
        cause: why it is so, where that can be established.
        fix: where one edit is uniquely right.
        kind: what it has in common with others of the same cause in the file; by default `what` without its names and
            numbers.
        document: the file that `at` is in, if it is not the description.
    """

    at: Span
    what: str
    remedy: str
    measured: float | None = None
    bound: float | None = None
    subject: Subject | None = HERE
    severity: Severity | None = None
    cause: str | None = None
    fix: Fix | None = None
    kind: str | None = None
    document: Document | None = None


Faults = Iterable[Fault]


def text_faults(context: Context, code: str) -> Faults:
    """Return what the reader of XML has noted for a rule."""
    return [Fault(found.at, found.what, found.remedy, subject=None) for found in context.reading.found(code)]


@dataclass(frozen=True, slots=True)
class Rule:
    """One rule with its documentation; `bad` and `good` are whole descriptions, and tests run both.

    Attributes:
        default: findings of this severity and above belong to the default set; the others are shown where the rule or
            ALL is selected.
        explains: codes of rules whose finding about the same link or joint is the same defect as this rule's.
    """

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
    explains: tuple[str, ...] = ()

    @property
    def in_default(self) -> bool:
        """Whether its usual finding belongs to the default set."""
        return self.severity.reaches(self.default)


def rule(
    severity: Severity,
    stage: Stage = Stage.DOCUMENT,
    *,
    good: str,
    bad: str | tuple[str, str],
    explanation: str = "",
    default: Severity = Severity.WARNING,
    explains: tuple[str, ...] = (),
) -> Callable[[Callable[[Context], Faults]], Rule]:
    """Make the decorated function the rule of its module: `rd201_mass_not_positive` is RD201, mass-not-positive.

    The module's docstring is the summary, one sentence, and after a blank line the explanation.

    Args:
        good, bad: descriptions; a pair is a piece of the good one and what stands in its place in the bad one.
        explanation: in place of the docstring's, where it has figures in it.
        default: ERROR for a rule whose warnings are a matter of taste or of one program, NOTE where remarks matter.
        explains: see `Rule`.
    """
    wrong = bad if isinstance(bad, str) else good.replace(*bad)

    def decorate(check: Callable[[Context], Faults]) -> Rule:
        code, _, name = check.__module__.rpartition(".")[2].partition("_")
        summary, _, text = (sys.modules[check.__module__].__doc__ or "").partition("\n\n")
        names = code.upper(), name.replace("_", "-")
        words = summary, explanation or text.strip()
        return Rule(*names, severity, stage, *words, wrong, good, check, default, explains)

    return decorate
