"""Baselines: findings that a project has taken note of, recognized although lines moved and numbers changed."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from robodyn.checks.rule import Finding
from robodyn.errors import InputError
from robodyn.support.files import write_whole
from robodyn.support.input_file import read_input

_NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.]*\w)")


class Identity(NamedTuple):
    """A finding without its place and its numbers; `file` with slashes."""

    file: str
    code: str
    subject: str
    message: str


def identity(finding: Finding, folder: str = "") -> Identity:
    """Return the identity of a finding, its file being named relative to a folder, by default as it was given.

    Numbers that stand alone in the message become `#`; those that are part of a name (`link_2`) stay.
    """
    path = os.path.relpath(finding.file, folder) if folder and not finding.file.startswith("<") else finding.file
    subject = "" if finding.subject is None else f"{finding.subject.kind} {finding.subject.name}"
    return Identity(path.replace(os.sep, "/"), finding.code, subject, _NUMBER.sub("#", finding.message))


def fingerprints(findings: Iterable[Finding]) -> Iterator[str]:
    """Yield a name for each finding: 64 hexadecimal digits of its identity, and which one of that identity it is."""
    seen: Counter[Identity] = Counter()
    for finding in findings:
        same = identity(finding)
        seen[same] += 1
        digest = hashlib.sha256("\0".join(same).encode("utf-8", "replace")).hexdigest()
        yield f"{digest}:{seen[same]}"


VERSION = 1


@dataclass(frozen=True)
class Compared:
    """The findings that are not in a baseline, how many are, and how many of its entries are no longer found."""

    new: tuple[Finding, ...]
    known: int
    gone: int


def compared(findings: Iterable[Finding], path: str) -> Compared:
    """Return the findings against a baseline. One that is there k times allows the first k findings of its identity.

    Raises:
        InputError: the file cannot be read or is no baseline.
    """
    left = _read(path)
    total = left.total()
    new = []
    folder = os.path.dirname(os.path.abspath(path))
    for finding in findings:
        same = identity(finding, folder)
        if left[same] > 0:
            left[same] -= 1
        else:
            new.append(finding)
    gone = left.total()
    return Compared(tuple(new), total - gone, gone)


def write_baseline(findings: Iterable[Finding], path: str) -> int:
    """Write the findings as a baseline, one a line and in order, and return how many there are.

    Raises:
        InputError: the file cannot be written.
    """
    folder = os.path.dirname(os.path.abspath(path))
    counts = Counter(identity(finding, folder) for finding in findings)
    lines = [json.dumps({**same._asdict(), "count": count}) for same, count in sorted(counts.items())]
    inside = "\n    " + ",\n    ".join(lines) + "\n  " if lines else ""
    write_whole(path, f'{{\n  "robodyn_baseline": {VERSION},\n  "findings": [{inside}]\n}}\n'.encode())
    return counts.total()


def _read(path: str) -> Counter[Identity]:
    try:
        document = json.loads(read_input(path))
    except FileNotFoundError:
        raise InputError("there is no such baseline", remedy="write it with --write-baseline", file=path) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=path) from None
    except (ValueError, RecursionError):
        raise _no_baseline(path) from None
    if not isinstance(document, Mapping) or document.get("robodyn_baseline") != VERSION:
        raise _no_baseline(path)
    try:
        entries = [({**entry}, entry["count"]) for entry in document["findings"]]
        return Counter({Identity(*(str(entry[key]) for key in Identity._fields)): int(n) for entry, n in entries})
    except (KeyError, TypeError, ValueError):
        raise _no_baseline(path) from None


def _no_baseline(path: str) -> InputError:
    return InputError("this is no baseline", remedy="write it anew with --write-baseline", file=path)
