"""The places of a finding in words, and the short form of a check: by file and by rule, the most severe first."""

from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import groupby
from textwrap import wrap

from robodyn.checks.check import Checked
from robodyn.checks.rule import Finding
from robodyn.report.check_words import LEVELS, checked_lines
from robodyn.report.document import Section, paragraphs
from robodyn.support.wording import count

_NAMED, _SAID = 40, 10
"""Further places that are listed: by name alone, and with a sentence each."""
_WIDTH = 100


def further(finding: Finding) -> list[str]:
    """Return lines with the further places of a finding: in a row where they are alike, else each with its sentence,
    and with what its cause may be where that is another."""
    alike = all((other.what, other.cause) == (finding.what, finding.cause) for other in finding.others)
    most = _NAMED if alike else _SAID
    shown, more = finding.others[:most], len(finding.others) - most
    rest = [f"{count(more, 'more place')}"] if more > 0 else []
    if alike:
        row = ", ".join([*map(place_words, shown), *rest])
        return wrap(row, _WIDTH, break_long_words=False, break_on_hyphens=False)
    return [*(f"{place_words(other)}: {other.what}{_cause(other, finding)}" for other in shown), *rest]


def _cause(other: Finding, finding: Finding) -> str:
    return "" if other.cause in (None, finding.cause) else f"; {other.cause}"


def place_words(finding: Finding) -> str:
    """`31:12 link 'arm'`"""
    at = f"{finding.line}:{finding.column}"
    return at if finding.subject is None else f"{at} {finding.subject.words}"


def short_sections(checked: Checked) -> Iterator[Section]:
    """Yield for each file its rules, the most severe first, and the places of each; at the end how many there are."""
    order = list(LEVELS)
    files: dict[str, list[Finding]] = {}
    for finding in checked.findings:
        files.setdefault(finding.file, []).append(finding)
    for file, found in files.items():
        ranked = sorted(found, key=lambda one: (order.index(one.severity), one.code))
        lines = [relative(file)]
        for head, same in groupby(ranked, key=lambda one: f"{one.severity.value} {one.code} {one.name}"):
            lines += [f"  {head}", *(line for one in same for line in _short(one))]
        yield paragraphs(lines)
    yield paragraphs(checked_lines(checked))


def _short(finding: Finding) -> list[str]:
    shown, more = finding.others[:_SAID], len(finding.others) - _SAID
    also = ", ".join([*map(place_words, shown), *([count(more, "more place")] if more > 0 else [])])
    first = f"    {finding.line}:{finding.column}: {finding.message}"
    return [first, *(f"      also {line}" for line in [also] if line)]


def relative(file: str) -> str:
    """Return the path from the current folder, where that is shorter."""
    if file.startswith("<"):
        return file
    try:
        return min(os.path.relpath(file), file, key=len)
    except ValueError:  # on another drive
        return file
