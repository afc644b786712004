"""Findings as text for a person: place, message, the line of the source with a caret, and what to do."""

from __future__ import annotations

from robodyn.checks.rule import Excerpt, Finding
from robodyn.checks.run import Checked
from robodyn.report.check_words import check_line, counted
from robodyn.report.table import printable


def check_text(checked: Checked) -> str:
    """The report: every finding, and at the end how many there are in how many files."""
    return "".join(f"{_finding(finding)}\n" for finding in checked.findings) + _summary(checked)


def _finding(finding: Finding) -> str:
    place = f"{finding.file}:{finding.line}:{finding.column}"
    lines = [
        f"{place}: {finding.severity.value} {finding.code} {finding.name}: {finding.message}",
        *marked(finding.line, finding.excerpt),
    ]
    if finding.cause is not None:
        lines.append(f"  cause: {finding.cause}")
    lines.append(f"  do: {finding.remedy}")
    if finding.fix is not None:
        lines.append(f"  fix: {finding.fix.what} ({'safe' if finding.fix.safe else 'unsafe'})")
    return "".join(f"{printable(line)}\n" for line in lines)


def marked(line: int, excerpt: Excerpt) -> list[str]:
    """The source and the caret below; the lines that a terminal would break are escaped before they are counted."""
    if not excerpt.text:
        return []
    before, within = excerpt.text[: excerpt.start], excerpt.text[excerpt.start : excerpt.start + excerpt.length]
    margin = f"  {line} | "
    gap = " " * (len(margin) - 2)
    return [margin + excerpt.text, f"{gap}| {' ' * len(printable(before))}{'^' * max(len(printable(within)), 1)}"]


def _summary(checked: Checked) -> str:
    return f"{counted(len(checked.files), 'file')} checked: {check_line(checked)}\n"
