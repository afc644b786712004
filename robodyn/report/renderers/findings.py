"""Findings for other programs: JUnit XML, GitHub's workflow commands, and SARIF 2.1.0."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from functools import cache
from html import escape
from itertools import pairwise
from pathlib import Path
from typing import Any
from urllib.parse import quote

from robodyn.checks.check import Checked, Unread
from robodyn.checks.groups import file_by_file, fingerprints
from robodyn.checks.rule import Finding, Rule, Severity
from robodyn.report.check import further
from robodyn.report.document import code_lines, finite
from robodyn.report.table import printable
from robodyn.robot.urdf.document import Document, SourcePositions
from robodyn.support.wording import count

COMMANDS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.NOTE: "notice"}
SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
Object = dict[str, Any]
Region = Callable[[str, int, int], Object]
"""File, and the bytes [start, end) in it, to a SARIF region."""
_LINKED = 20
"""Further places that the message links to."""


def check_junit(checked: Checked, strict: bool = False) -> str:
    """Return a suite for each file, in it a test for each finding, failed if it fails the check (strict: warnings,
    too), or one that passes. Findings in macros and SRDF are in the suite of their description; their class is their
    own file. The format is that of Jenkins' xUnit plugin (junit-10.xsd)."""
    fatal = {Severity.ERROR, Severity.WARNING} if strict else {Severity.ERROR}
    found: dict[str, list[Finding]] = {file: [] for file in checked.files}
    for one in file_by_file(checked.findings):
        found.setdefault(one.checked, []).append(one)
    suites, failures = [], 0
    for file, findings in found.items():
        cases = []
        for one in findings:
            place = f"{one.file}:{one.line}:{one.column}"
            name = _attribute(f"{one.code} {one.name} {one.line}:{one.column}")
            said = "\n".join([f"{place}: {one.severity.value}: {one.message}", *_below(one)])
            text = escape(code_lines(said), quote=False)  # html's, for those of xml bring a client for HTTP along
            what = f"<system-out>{text}</system-out>"
            if one.severity in fatal:
                what = f'<failure type="{one.code}" message={_attribute(one.message)}>{text}</failure>'
            head = f'    <testcase name={name} classname={_attribute(one.file)} time="0">'
            cases.append(f"{head}\n      {what}\n    </testcase>")
        cases = cases or [f'    <testcase name="no findings" classname={_attribute(file)} time="0"/>']
        failed = sum(one.severity in fatal for one in findings)
        counts = f'tests="{len(cases)}" failures="{failed}" errors="0" time="0"'
        suites += [f"  <testsuite name={_attribute(file)} {counts}>", *cases, "  </testsuite>"]
        failures += failed
    for unread in checked.unread:
        name = _attribute(unread.file)
        suites += [
            f'  <testsuite name={name} tests="1" failures="0" errors="1" time="0">',
            f'    <testcase name="reading" classname={name} time="0">',
            f"      <error message={_attribute(unread.why)}/>",
            "    </testcase>\n  </testsuite>",
        ]
    tests = sum(part.count("<testcase ") for part in suites)
    head = f'<testsuites name="robodyn check" tests="{tests}" failures="{failures}" errors="{len(checked.unread)}">'
    return "\n".join(['<?xml version="1.0" encoding="UTF-8"?>', head, *suites, "</testsuites>\n"])


def _below(finding: Finding) -> list[str]:
    cause = [f"cause: {finding.cause}"] if finding.cause else []
    return [*(f"also: {line}" for line in further(finding)), *cause, f"remedy: {finding.remedy}"]


def _attribute(text: str) -> str:
    return '"{}"'.format(escape(printable(text), quote=False).replace('"', "&quot;"))


def check_github(findings: Sequence[Finding], unread: Sequence[Unread] = ()) -> str:
    """Return one line for each finding, `::error file=F,line=L,col=C,title=T::message`, and for each file not read,
    escaped as the runner's own toolkit does (actions/toolkit, packages/core/src/command.ts)."""
    lines = []
    for finding in file_by_file(findings):
        of = "" if finding.description is None else f" (in {finding.description})"
        message = "\n".join(map(printable, [finding.message + of, *_below(finding)]))
        place = f"file={_property(_path(finding.file))},line={finding.line},col={finding.column}"
        title = _property(f"{finding.code} {finding.name}")
        lines.append(f"::{COMMANDS[finding.severity]} {place},title={title}::{_escaped(message)}\n")
    lines += [f"::error file={_property(_path(each.file))}::{_escaped(each.why)}\n" for each in unread]
    return "".join(lines)


def _path(file: str) -> str:
    return file if file.startswith("<") else os.path.normpath(file).replace(os.sep, "/")


def _escaped(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    """Return a property; whatever turns text around or drives a terminal is shown, not done."""
    shown = "".join(letter if letter in "\r\n" else printable(letter) for letter in text)
    return _escaped(shown).replace(":", "%3A").replace(",", "%2C")


def check_sarif(
    findings: Sequence[Finding],
    rules: Sequence[Rule],
    reading: Callable[[str], Document],
    unread: Sequence[Unread] = (),
) -> str:
    """Return one run with the rules' documentation; of each finding place, link or joint, numbers and fix. Columns
    count characters from 1; `partialFingerprints` stay the same when lines move or numbers change; `reading` leads from
    the name of a file to its reading, in whose bytes findings have their places."""
    from importlib.metadata import version

    @cache
    def places(file: str) -> SourcePositions:
        found = reading(file)
        return SourcePositions(found.data, found.encoding)

    def region(file: str, start: int, end: int) -> Object:
        first, last = places(file).span(start, start), places(file).span(end, end)
        return {"startLine": first.line, "startColumn": first.column, "endLine": last.line, "endColumn": last.column}

    index, findings = {rule.code: k for k, rule in enumerate(rules)}, [*file_by_file(findings)]
    named = zip(findings, fingerprints(findings), strict=True)
    results = [_result(finding, index, name, region) for finding, name in named]
    own = version("robodyn")
    explained = [
        {
            "id": rule.code,
            "name": rule.name,
            "shortDescription": {"text": rule.summary},
            "fullDescription": {"text": rule.explanation},
            "help": {"text": f"{rule.explanation}\n\nBad:\n\n{rule.bad}\nGood:\n\n{rule.good}"},
            "defaultConfiguration": {"level": rule.severity.value},
        }
        for rule in rules
    ]
    driver = {"name": "robodyn", "version": own, "semanticVersion": own, "rules": explained}
    invocation: Object = {"executionSuccessful": not unread}
    for each in unread:
        place = {"physicalLocation": {"artifactLocation": _artifact(each.file)}}
        fault = {"level": "error", "message": {"text": each.why}, "locations": [place]}
        invocation.setdefault("toolExecutionNotifications", []).append(fault)
    run: Object = {"tool": {"driver": driver}, "invocations": [invocation]}
    run |= {"columnKind": "unicodeCodePoints", "results": results}
    return json.dumps({"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}, indent=2) + "\n"


def _result(finding: Finding, index: dict[str, int], name: str, region: Region) -> Object:
    cause = f" Cause: {finding.cause}." if finding.cause else ""
    links = [f"[line {other.line}]({k})" for k, other in enumerate(finding.others[:_LINKED], 1)]
    links += [count(more, "more place")] if (more := len(finding.others) - _LINKED) > 0 else []
    also = f" Also in {', '.join(links)}." if links else ""  # readers of SARIF make links to related locations of these
    result: Object = {
        "ruleId": finding.code,
        "level": finding.severity.value,
        "message": {"text": f"{finding.message}.{also}{cause} Remedy: {finding.remedy}."},
        "locations": [_location(finding, region)],
        "partialFingerprints": {"robodynFinding/v2": name},
    }
    if finding.others:
        result["occurrenceCount"] = len(finding.places)
        result["relatedLocations"] = [
            {"id": k, **_location(other, region), "message": {"text": other.message}}
            for k, other in enumerate(finding.others, 1)
        ]
    if finding.code in index:
        result["ruleIndex"] = index[finding.code]
    numbers = {"measured": finite(finding.measured), "bound": finite(finding.bound)}
    if known := {key: value for key, value in numbers.items() if value is not None}:
        result["properties"] = known
    if finding.fix is not None:
        every = {edit for place in finding.places if place.fix for edit in place.fix.edits}
        edits = sorted(every, key=lambda edit: edit.start)  # of all places, or of the first where some touch
        edits = list(finding.fix.edits) if any(a.end > b.start for a, b in pairwise(edits)) else edits
        replacements = [
            {"deletedRegion": region(finding.file, edit.start, edit.end), "insertedContent": {"text": edit.text}}
            for edit in edits
        ]
        change = {"artifactLocation": _artifact(finding.file), "replacements": replacements}
        result["fixes"] = [{"description": {"text": finding.fix.what}, "artifactChanges": [change]}]
    return result


def _location(finding: Finding, region: Region) -> Object:
    place = region(finding.file, finding.start, finding.end)
    location: Object = {"physicalLocation": {"artifactLocation": _artifact(finding.file), "region": place}}
    if finding.subject is not None:
        kind, named = finding.subject.kind, finding.subject.name
        location["logicalLocations"] = [{"name": named, "kind": kind, "fullyQualifiedName": f"{kind}/{named}"}]
    return location


def _artifact(file: str) -> Object:
    return {"uri": Path(file).as_uri() if os.path.isabs(file) else quote(_path(file))}
