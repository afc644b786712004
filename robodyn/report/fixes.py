"""What fixing has done: a unified diff of the text, and a line for each fix."""

from __future__ import annotations

import re
from collections.abc import Iterable

from robodyn.checks.fixes.fix import Fixed, Made
from robodyn.checks.rule import Finding
from robodyn.report.table import printable


def check_diff(fixed: Fixed) -> str:
    """The unified diff of one file, empty where nothing changes. Lines end with LF alone; a CR is part of its line."""
    from difflib import unified_diff

    before, after = _lines(fixed.before), _lines(fixed.after)
    name = printable(fixed.file)
    lines = unified_diff(before, after, name, name)
    return "".join(line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n" for line in lines)


def fix_lines(files: Iterable[Fixed], did: str) -> list[str]:
    """A line for each fix that was made, `did` it being said how, and for each that was not, with the reason."""
    lines = []
    for fixed in files:
        lines += [f"{did}: {_place(one.finding)}: {one.fix.what} ({_kind(one)})" for one in fixed.made]
        lines += [f"not fixed: {_place(one.finding)}: {one.fix.what} ({one.why})" for one in fixed.refused]
    return [printable(line) for line in lines]


def _lines(data: bytes) -> list[str]:
    return re.findall(r"[^\n]*\n|[^\n]+", data.decode("utf-8", "surrogateescape"))


def _place(finding: Finding) -> str:
    subject = f", {finding.subject.kind} {finding.subject.name}" if finding.subject else ""
    return f"{finding.file}:{finding.line}: {finding.code}{subject}"


def _kind(made: Made) -> str:
    if made.fix.safe:
        return "safe: the dynamics stay as they are"
    if made.change is None:
        return "unsafe: by how much the torques change cannot be computed"
    return f"unsafe: torques change by up to {100 * made.change:.3g} % of the largest"
