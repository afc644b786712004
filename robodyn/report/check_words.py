"""What a check has found, in one line and as a verdict: the same words wherever a description is judged."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from robodyn.checks.rule import Severity
from robodyn.report.document import Level, Verdict
from robodyn.support.wording import count

if TYPE_CHECKING:
    from robodyn.checks.check import Checked

LEVELS: dict[Severity, Level] = {Severity.ERROR: "bad", Severity.WARNING: "doubtful", Severity.NOTE: "neutral"}
UNFIT = "not fit for use as it is"
_NAMED = 8


def check_line(checked: Checked) -> str:
    """Return how many findings there are of each kind, at how many places, and whether the description is unfit."""
    counts = ", ".join(count(checked.count(severity), severity.value) for severity in LEVELS)
    places = sum(len(finding.places) for finding in checked.findings)
    at = f" at {places} places" if places > len(checked.findings) else ""
    said = f"{counts}{at}{'' if checked.fit else f': {UNFIT}'}" if checked.findings else "nothing found"
    return f"{said}; {count(len(checked.unread), 'file')} could not be read" if checked.unread else said


def checked_lines(checked: Checked) -> list[str]:
    """Return what is not shown, if anything, and at the end how many files were checked and what was found."""
    line = f"{count(len(checked.files), 'file')} checked: {check_line(checked)}"
    return [f"not shown: {hidden_line(checked)}", line] if checked.hidden else [line]


def hidden_line(checked: Checked) -> str:
    """Return how many findings are not shown, and what shows them."""
    rules = len({finding.code for finding in checked.hidden})
    return f"{count(len(checked.hidden), 'minor finding')} of {count(rules, 'rule')} (--select ALL)"


def check_data(checked: Checked) -> dict[str, Any]:
    """Return the same for JSON."""
    return {**{f"{severity.value}s": checked.count(severity) for severity in LEVELS}, "fit": checked.fit}


def check_verdict(checked: Checked) -> Verdict:
    """Return whether the descriptions can be used, and the first errors."""
    errors, warnings, notes = (checked.count(severity) for severity in LEVELS)
    if errors:
        level, headline = LEVELS[Severity.ERROR], f"{count(errors, 'error')}: {UNFIT}"
    elif checked.unread:
        level, headline = "bad", f"{count(len(checked.unread), 'file')} could not be read"
    elif warnings:
        level, headline = LEVELS[Severity.WARNING], f"No errors, {count(warnings, 'warning')}"
    else:
        more = f", {count(notes, 'note')}" if notes else ""
        level, headline = "good", f"No errors and no warnings{more}"
    return Verdict(level, headline, (*error_lines(checked), *(f"{each.file}: {each.why}." for each in checked.unread)))


def error_lines(checked: Checked) -> list[str]:
    """Return a sentence for each of the first errors, with its place."""
    worst = [finding for finding in checked.findings if finding.severity is Severity.ERROR]
    lines = [f"{finding.file}, line {finding.line}: {finding.message}." for finding in worst[:_NAMED]]
    more = len(worst) - len(lines)
    return [*lines, f"{count(more, 'more error')}: robodyn check lists all."] if more else lines
