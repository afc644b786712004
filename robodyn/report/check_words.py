"""What a check has found, in one line and as a verdict: the same words wherever a description is judged."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from robodyn.checks.rule import Severity
from robodyn.report.document import Level, Verdict

if TYPE_CHECKING:
    from robodyn.checks.run import Checked

LEVELS: dict[Severity, Level] = {Severity.ERROR: "bad", Severity.WARNING: "doubtful", Severity.NOTE: "neutral"}
UNFIT = "not fit for use as it is"
_NAMED = 8


def counted(count: int, noun: str) -> str:
    """Return a number with its noun: 1 file, 2 files."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def check_line(checked: Checked) -> str:
    """Return how many findings there are of each kind, and whether the description is unfit."""
    counts = ", ".join(counted(checked.count(severity), severity.value) for severity in LEVELS)
    said = f"{counts}{'' if checked.fit else f': {UNFIT}'}" if checked.findings else "nothing found"
    return f"{said}; {counted(len(checked.unread), 'file')} could not be read" if checked.unread else said


def check_data(checked: Checked) -> dict[str, Any]:
    """Return the same for JSON."""
    return {**{f"{severity.value}s": checked.count(severity) for severity in LEVELS}, "fit": checked.fit}


def check_verdict(checked: Checked) -> Verdict:
    """Return whether the descriptions can be used, and the first errors."""
    errors, warnings, notes = (checked.count(severity) for severity in LEVELS)
    if errors:
        level, headline = LEVELS[Severity.ERROR], f"{counted(errors, 'error')}: {UNFIT}"
    elif checked.unread:
        level, headline = "bad", f"{counted(len(checked.unread), 'file')} could not be read"
    elif warnings:
        level, headline = LEVELS[Severity.WARNING], f"No errors, {counted(warnings, 'warning')}"
    else:
        more = f", {counted(notes, 'note')}" if notes else ""
        level, headline = "good", f"No errors and no warnings{more}"
    return Verdict(level, headline, (*error_lines(checked), *(f"{each.file}: {each.why}." for each in checked.unread)))


def error_lines(checked: Checked) -> list[str]:
    """Return a sentence for each of the first errors, with its place."""
    worst = [finding for finding in checked.findings if finding.severity is Severity.ERROR]
    lines = [f"{finding.file}, line {finding.line}: {finding.message}." for finding in worst[:_NAMED]]
    more = len(worst) - len(lines)
    return [*lines, f"{counted(more, 'more error')}: robodyn check lists all."] if more else lines
