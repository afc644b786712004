"""What makes two findings the same one, although lines have moved and numbers have changed."""

from __future__ import annotations

import hashlib
import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from robodyn.checks.rule import Finding

_NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.]*\w)")


class Identity(NamedTuple):
    """A finding without its place and its numbers; `file` with slashes."""

    file: str
    code: str
    subject: str
    message: str


def identity(finding: Finding, folder: str = "") -> Identity:
    """The identity of a finding, its file being named relative to a folder, by default as it was given.

    Numbers that stand alone in the message become `#`; those that are part of a name (`link_2`) stay.
    """
    path = os.path.relpath(finding.file, folder) if folder and not finding.file.startswith("<") else finding.file
    subject = "" if finding.subject is None else f"{finding.subject.kind} {finding.subject.name}"
    return Identity(path.replace(os.sep, "/"), finding.code, subject, _NUMBER.sub("#", finding.message))


def fingerprints(findings: Iterable[Finding]) -> Iterator[str]:
    """A name for each finding: 64 hexadecimal digits of its identity, and which one of that identity it is."""
    seen: Counter[Identity] = Counter()
    for finding in findings:
        same = identity(finding)
        seen[same] += 1
        digest = hashlib.sha256("\0".join(same).encode("utf-8", "replace")).hexdigest()
        yield f"{digest}:{seen[same]}"
