"""Findings for continuous integration: JUnit XML, which servers show as tests, and GitHub's workflow commands."""

from __future__ import annotations

import os
from collections.abc import Sequence

from robodyn.checks.check import Checked, Unread
from robodyn.checks.rule import Finding, Severity
from robodyn.report.check_places import further
from robodyn.report.table import printable


def check_junit(checked: Checked, strict: bool = False) -> str:
    """Return a suite for each file, in it a test for each finding: failed if it fails the check.

    A file without findings has one test, which passes. Findings in macros that a description includes, or in its SRDF,
    are in its suite; their class is the file that they are in. The format is that of Jenkins' xUnit plugin
    (junit-10.xsd).

    Args:
        checked: what was found.
        strict: warnings fail, too.
    """
    fatal = {Severity.ERROR, Severity.WARNING} if strict else {Severity.ERROR}
    found: dict[str, list[Finding]] = {file: [] for file in checked.files}
    for one in checked.findings:
        found.setdefault(one.checked, []).append(one)
    suites = [_suite(file, findings, fatal) for file, findings in found.items()]
    suites += map(_unread, checked.unread)
    failures = sum(finding.severity in fatal for finding in checked.findings)
    tests = sum(max(suite.count("<testcase "), 1) for suite in suites)
    head = f'<testsuites name="robodyn check" tests="{tests}" failures="{failures}" errors="{len(checked.unread)}">'
    return "\n".join(['<?xml version="1.0" encoding="UTF-8"?>', head, *suites, "</testsuites>\n"])


def _suite(file: str, findings: Sequence[Finding], fatal: set[Severity]) -> str:
    cases = [_case(finding, fatal) for finding in findings] or [
        f'    <testcase name="no findings" classname={_attribute(file)} time="0"/>'
    ]
    failures = sum(finding.severity in fatal for finding in findings)
    counts = f'tests="{len(cases)}" failures="{failures}" errors="0" time="0"'
    return "\n".join([f"  <testsuite name={_attribute(file)} {counts}>", *cases, "  </testsuite>"])


def _unread(unread: Unread) -> str:
    """Return the suite of a file that could not be read."""
    file = _attribute(unread.file)
    return f"""  <testsuite name={file} tests="1" failures="0" errors="1" time="0">
    <testcase name="reading" classname={file} time="0">
      <error message={_attribute(unread.why)}/>
    </testcase>
  </testsuite>"""


def _case(finding: Finding, fatal: set[Severity]) -> str:
    place = f"{finding.file}:{finding.line}:{finding.column}"
    name = f"{finding.code} {finding.name} {finding.line}:{finding.column}"
    head = f'    <testcase name={_attribute(name)} classname={_attribute(finding.file)} time="0">'
    cause = f"\ncause: {finding.cause}" if finding.cause else ""
    also = "".join(f"\nalso: {line}" for line in further(finding))
    text = _text(f"{place}: {finding.severity.value}: {finding.message}{also}{cause}\nremedy: {finding.remedy}")
    if finding.severity in fatal:
        what = f'<failure type="{finding.code}" message={_attribute(finding.message)}>{text}</failure>'
    else:
        what = f"<system-out>{text}</system-out>"
    return f"{head}\n      {what}\n    </testcase>"


def _attribute(text: str) -> str:
    # Imported here, for it brings the client for HTTP along.
    from xml.sax.saxutils import quoteattr

    return quoteattr(printable(text))


def _text(text: str) -> str:
    from xml.sax.saxutils import escape

    return "\n".join(escape(printable(line)) for line in text.split("\n"))


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
    of = "" if finding.description is None else f" (in {finding.description})"
    parts = [printable(finding.message + of), *(f"also: {printable(line)}" for line in further(finding))]
    if finding.cause:
        parts.append(f"cause: {printable(finding.cause)}")
    return "\n".join([*parts, f"remedy: {printable(finding.remedy)}"])


def _escaped(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    """Return a property; whatever turns text around or drives a terminal is shown, not done."""
    return (
        _escaped("".join(letter if letter in "\r\n" else printable(letter) for letter in text))
        .replace(":", "%3A")
        .replace(",", "%2C")
    )
