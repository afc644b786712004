"""Findings as workflow commands, which GitHub shows beside the lines of a pull request."""

from __future__ import annotations

import os
from collections.abc import Sequence

from robodyn.checks.rule import Finding, Severity
from robodyn.checks.run import Unread
from robodyn.report.table import printable

COMMANDS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.NOTE: "notice"}


def check_github(findings: Sequence[Finding], unread: Sequence[Unread] = ()) -> str:
    """Return one line for each finding, `::error file=F,line=L,col=C,title=T::message`, and for each file not read.

    Method: percent, CR and LF are written %25, %0D and %0A, in properties colon and comma %3A and %2C as well, as the
    runner's own toolkit does (actions/toolkit, packages/core/src/command.ts).
    """
    faults = [f"::error file={_property(_path(each.file))}::{_escaped(each.why)}\n" for each in unread]
    return "".join([*map(_line, findings), *faults])


def _line(finding: Finding) -> str:
    properties = {
        "file": _path(finding.file),
        "line": str(finding.line),
        "col": str(finding.column),
        "title": f"{finding.code} {finding.name}",
    }
    listed = ",".join(f"{key}={_property(value)}" for key, value in properties.items())
    return f"::{COMMANDS[finding.severity]} {listed}::{_escaped(_message(finding))}\n"


def _path(file: str) -> str:
    """Return the path as the repository has it, without `./`; standard input as it is."""
    return file if file.startswith("<") else os.path.normpath(file).replace(os.sep, "/")


def _message(finding: Finding) -> str:
    parts = [printable(finding.message)]
    if finding.cause:
        parts.append(f"cause: {printable(finding.cause)}")
    return "\n".join([*parts, f"remedy: {printable(finding.remedy)}"])


def _escaped(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _escaped(text).replace(":", "%3A").replace(",", "%2C")
