"""Findings of one cause made one: the same slip at many places, two rules that speak of the same defect; and those of
before, which a baseline knows.

Rules, waivers, fixes and baselines work on each place by itself. What a user is shown has one finding for each file,
rule, severity and kind, with its places.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from operator import attrgetter
from typing import NamedTuple

from robodyn.checks.rule import Finding, Rule
from robodyn.errors import InputError
from robodyn.robot.urdf.view import Subject
from robodyn.support.files import write_whole
from robodyn.support.input_file import parse_json, read_input
from robodyn.support.wording import surmised

_NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.]*\w)")
_NAME = re.compile(r"(?<!\w)(['\"]).*?\1(?!\w)")
_LIST = re.compile(r"#(?:, #)+(?:, \.\.\. \(# in all\)| and # more)?")
_SAID = attrgetter("subject", "message", "cause")
_MORE = re.compile(r" \(and (?:\d+|#) more[^()]*\)")
VERSION = 1


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
    """Return one finding for each cause in each file, with its further places, and for those that are equal in several
    files; in the order of the first places."""
    return across_files(_joined(findings, lambda one: (one.file, one.code, one.severity, one.kind, cause_of(one))))


def across_files(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return one finding for those that say the same of the same links and joints, with the places in all files."""
    return tuple(_joined(findings, lambda one: (one.code, one.severity, *map(_SAID, one.places))))


def _joined(findings: Iterable[Finding], key: Callable[[Finding], object]) -> Iterator[Finding]:
    """Yield one finding for those of the same key: the first, with the places of the others."""
    same: dict[object, list[Finding]] = {}
    for finding in findings:
        same.setdefault(key(finding), []).append(finding)
    for one, *others in same.values():
        more = (place for other in others for place in other.places)
        yield replace(one, others=(*one.others, *more)) if others else one


def file_by_file(findings: Iterable[Finding]) -> Iterator[Finding]:
    """Yield the findings for programs that want those of each file by themselves."""
    for finding in findings:
        yield from _joined((replace(place, others=()) for place in finding.places), lambda place: place.checked)


def across_robots(findings: Iterable[Finding]) -> list[Finding]:
    """Return the findings of several robots with one for each cause in a file that they share, and their names."""
    shared: dict[tuple[object, ...], Finding] = {}
    for one in (place for finding in findings for place in finding.places):
        key = (one.file, one.start, one.end, one.code, one.severity, one.message, one.cause)
        known = shared.get(key)
        robots = (one.checked,) if known is None else (*known.robots, one.checked)
        shared[key] = replace(known or one, robots=tuple(dict.fromkeys(robots)))
    together = grouped(shared.values())
    return [
        replace(one, robots=tuple(dict.fromkeys(robot for place in one.places for robot in place.robots)))
        for one in together
    ]


def places(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return every place of the findings by itself, file by file and each in the order of its text."""
    found = [place for finding in findings for place in finding.places]
    order = {file: k for k, file in enumerate(dict.fromkeys(place.file for place in found))}
    return tuple(sorted(found, key=lambda one: (order[one.file], one.start, one.code)))


def deduplicate(findings: Sequence[Finding], rules: Mapping[str, Rule]) -> list[Finding]:
    """Return the findings of one file without those that another rule explains for the same part. Of two that are one
    defect the one that explains stays, or else the more severe one, with what explains it as its cause."""
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


class Identity(NamedTuple):
    """A finding without its place and its numbers; `file` with slashes."""

    file: str
    code: str
    subject: str
    message: str


def identity(finding: Finding, folder: str = "") -> Identity:
    """The identity of a finding, its file being named relative to a folder, by default as it was given."""
    path = os.path.relpath(finding.file, folder) if folder and not finding.file.startswith("<") else finding.file
    subject = "" if finding.subject is None else f"{finding.subject.kind} {finding.subject.name}"
    return Identity(path.replace(os.sep, "/"), finding.code, subject, without_numbers(finding.message))


def fingerprints(findings: Iterable[Finding]) -> Iterator[str]:
    """Yield a name for each finding: 64 hexadecimal digits of file, code and what its places have in common, which stay
    when a place joins or goes, and which one it is of those that have them."""
    seen: Counter[tuple[str, ...]] = Counter()
    for finding in findings:
        file = finding.file.replace(os.sep, "/")
        same = (file, finding.code, finding.severity.value, finding.kind, cause_of(finding))
        seen[same] += 1
        digest = hashlib.sha256("\0".join(same).encode("utf-8", "replace")).hexdigest()
        yield f"{digest}:{seen[same]}"


def compared(findings: Iterable[Finding], path: str) -> tuple[tuple[Finding, ...], int, int]:
    """Return the findings that are not in a baseline, how many are, and how many of its entries are no longer found,
    place by place: an entry that is there k times allows the first k places of its identity. InputError where the file
    cannot be read or is no baseline."""
    left, folder, new = _read(path), os.path.dirname(os.path.abspath(path)), list[Finding]()
    total = left.total()
    for finding in places(findings):
        same = identity(finding, folder)
        if left[same] > 0:
            left[same] -= 1
        else:
            new.append(finding)
    gone = left.total()
    return grouped(new), total - gone, gone


def write_baseline(findings: Iterable[Finding], path: str) -> int:
    """Write the findings as a baseline, a line for each place, in order, and return how many there are; or
    InputError."""
    folder = os.path.dirname(os.path.abspath(path))
    counts = Counter(identity(finding, folder) for finding in places(findings))
    lines = [json.dumps({**same._asdict(), "count": count}) for same, count in sorted(counts.items())]
    inside = "\n    " + ",\n    ".join(lines) + "\n  " if lines else ""
    write_whole(path, f'{{\n  "robodyn_baseline": {VERSION},\n  "findings": [{inside}]\n}}\n'.encode())
    return counts.total()


def _read(path: str) -> Counter[Identity]:
    wrong = InputError("this is no baseline", remedy="write it anew with --write-baseline", file=path)
    try:
        document = parse_json(read_input(path), path)
        if not isinstance(document, Mapping) or document.get("robodyn_baseline") != VERSION:
            raise wrong
        known = Counter[Identity]()
        for entry in document["findings"]:
            same = Identity(*(str(entry[key]) for key in Identity._fields))
            known[same._replace(message=without_numbers(same.message))] += int(entry["count"])
        return known
    except FileNotFoundError:
        raise InputError("there is no such baseline", remedy="write it with --write-baseline", file=path) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=path) from None
    except (KeyError, TypeError, ValueError, OverflowError, RecursionError):
        raise wrong from None
