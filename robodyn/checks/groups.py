"""Findings of one cause made one: the same slip at many places, and two rules that speak of the same defect.

Rules, waivers, fixes and baselines work on each place by itself. What a user is shown has one finding for each file,
rule, severity and kind, with its places.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from robodyn.checks.rule import Finding, Rule
from robodyn.robot.urdf.view import Subject
from robodyn.support.wording import surmised

_NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.]*\w)")
_NAME = re.compile(r"(?<!\w)(['\"]).*?\1(?!\w)")
_LIST = re.compile(r"#(?:, #)+(?:, \.\.\. \(# in all\)| and # more)?")
_MORE = re.compile(r" \(and (?:\d+|#) more[^()]*\)")


def without_numbers(text: str) -> str:
    """A message with `#` for the numbers that stand alone (not `link_2`), and without how many more there are."""
    return _NUMBER.sub("#", _MORE.sub("", text))


def kind_of(what: str) -> str:
    """A message with `#` for numbers, quoted names and lists of them: what the same slip has in common."""
    return _LIST.sub("#", without_numbers(_NAME.sub("#", what)))


def cause_of(finding: Finding) -> str:
    """The kind of the cause of a finding; empty where none is known, but at most what it may be."""
    return "" if finding.cause is None or surmised(finding.cause) else kind_of(finding.cause)


def grouped(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return one finding for each cause in each file, with its further places; in the order of the first places."""
    together: dict[tuple[object, ...], list[Finding]] = {}
    for finding in findings:
        key = (finding.file, finding.code, finding.severity, finding.kind, cause_of(finding))
        together.setdefault(key, []).append(finding)
    return tuple(replace(one, others=tuple(others)) if others else one for one, *others in together.values())


def places(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return every place of the findings by itself, file by file and each in the order of its text."""
    files: dict[str, list[Finding]] = {}
    for finding in findings:
        files.setdefault(finding.file, []).extend(finding.places)
    return tuple(one for found in files.values() for one in sorted(found, key=lambda one: (one.start, one.code)))


def deduplicate(findings: Sequence[Finding], rules: Mapping[str, Rule]) -> list[Finding]:
    """Return the findings of one file without those that another rule explains, for the same link or joint.

    Of two that are one defect the one that explains stays, unless the other is more severe: then that one stays, and
    what explains it becomes its cause.
    """
    of: dict[tuple[Subject, str], list[Finding]] = {}
    for finding in findings:
        if finding.subject is not None:
            of.setdefault((finding.subject, finding.code), []).append(finding)
    dropped: set[int] = set()
    causes: dict[int, str] = {}
    for (subject, code), found in sorted(of.items(), key=lambda one: one[0][1]):
        for other in (other for explained in rules[code].explains for other in of.get((subject, explained), ())):
            if found[0].severity.reaches(other.severity):
                dropped.add(id(other))
            else:
                dropped.update(map(id, found))
                causes.setdefault(id(other), f"{found[0].what} ({code})")
    kept = (finding for finding in findings if id(finding) not in dropped)
    return [replace(one, cause=one.cause or causes.get(id(one))) if id(one) in causes else one for one in kept]
