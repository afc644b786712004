"""Baselines: findings that a project has taken note of, recognized although lines moved and numbers changed."""

from __future__ import annotations

import hashlib
import json
import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from robodyn.checks.groups import cause_of, grouped, places, without_numbers
from robodyn.checks.rule import Finding
from robodyn.errors import InputError
from robodyn.support.files import write_whole
from robodyn.support.input_file import parse_json, read_input

VERSION = 1


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


@dataclass(frozen=True)
class Compared:
    """The findings that are not in a baseline, how many are, and how many of its entries are no longer found."""

    new: tuple[Finding, ...]
    known: int
    gone: int


def compared(findings: Iterable[Finding], path: str) -> Compared:
    """Return the findings against a baseline, place by place: an entry that is there k times allows the first k places
    of its identity. InputError where the file cannot be read or is no baseline."""
    left, folder, new = _read(path), os.path.dirname(os.path.abspath(path)), list[Finding]()
    total = left.total()
    for finding in places(findings):
        same = identity(finding, folder)
        if left[same] > 0:
            left[same] -= 1
        else:
            new.append(finding)
    gone = left.total()
    return Compared(grouped(new), total - gone, gone)


def write_baseline(findings: Iterable[Finding], path: str) -> int:
    """Write the findings as a baseline, a line for each place and in order, and return how many there are; InputError
    where the file cannot be written."""
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
