"""Findings as SARIF 2.1.0, the form in which code hosts and editors take them."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Sequence
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any
from urllib.parse import quote

from robodyn.checks.baseline import fingerprints
from robodyn.checks.check import Unread
from robodyn.checks.rule import Edit, Finding, Fix, Rule
from robodyn.robot.urdf.document import Document
from robodyn.robot.urdf.elements import SourcePositions
from robodyn.support.wording import count

SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
Object = dict[str, Any]
Region = Callable[[str, int, int], Object]
"""File, and the bytes [start, end) in it, to a SARIF region."""


def check_sarif(
    findings: Sequence[Finding],
    rules: Sequence[Rule],
    reading: Callable[[str], Document],
    unread: Sequence[Unread] = (),
) -> str:
    """Return one run with the rules' documentation; of each finding place, link or joint, numbers and fix.

    Columns count characters from 1. `partialFingerprints` stay the same when lines move or numbers change.

    Args:
        findings: what was found.
        rules: those that ran.
        reading: from the name of a file to its reading, in whose bytes the findings have their places.
        unread: files that could not be checked.
    """
    from importlib.metadata import version

    places = cache(lambda file: _places(reading(file)))
    index = {rule.code: k for k, rule in enumerate(rules)}
    results = [
        _result(finding, index, name, lambda file, start, end: _region(places(file), start, end))
        for finding, name in zip(findings, fingerprints(findings), strict=True)
    ]
    driver = {
        "name": "robodyn",
        "version": version("robodyn"),
        "semanticVersion": version("robodyn"),
        "rules": [_rule(rule) for rule in rules],
    }
    invocation: Object = {"executionSuccessful": not unread}
    if unread:
        invocation["toolExecutionNotifications"] = list(map(_notification, unread))
    run = {
        "tool": {"driver": driver},
        "invocations": [invocation],
        "columnKind": "unicodeCodePoints",
        "results": results,
    }
    return json.dumps({"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}, indent=2) + "\n"


def _notification(unread: Unread) -> Object:
    location = {"physicalLocation": {"artifactLocation": _artifact(unread.file)}}
    return {"level": "error", "message": {"text": unread.why}, "locations": [location]}


def _rule(rule: Rule) -> Object:
    return {
        "id": rule.code,
        "name": rule.name,
        "shortDescription": {"text": rule.summary},
        "fullDescription": {"text": rule.explanation},
        "help": {"text": f"{rule.explanation}\n\nBad:\n\n{rule.bad}\nGood:\n\n{rule.good}"},
        "defaultConfiguration": {"level": rule.severity.value},
    }


def _result(finding: Finding, index: dict[str, int], name: str, region: Region) -> Object:
    cause = f" Cause: {finding.cause}." if finding.cause else ""
    also = _also(finding)
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
    numbers = {"measured": finding.measured, "bound": finding.bound}
    if known := {key: value for key, value in numbers.items() if value is not None and math.isfinite(value)}:
        result["properties"] = known
    if finding.fix is not None:
        result["fixes"] = [_fix(finding, finding.fix.what, _edits(finding, finding.fix), region)]
    return result


_LINKED = 20
"""Further places that the message links to."""


def _also(finding: Finding) -> str:
    """Return links to the related locations, in the form that readers of SARIF make links of."""
    links = [f"[line {other.line}]({k})" for k, other in enumerate(finding.others[:_LINKED], 1)]
    more = len(finding.others) - _LINKED
    listed = ", ".join([*links, *([count(more, "more place")] if more > 0 else [])])
    return f" Also in {listed}." if links else ""


def _location(finding: Finding, region: Region) -> Object:
    location: Object = {
        "physicalLocation": {
            "artifactLocation": _artifact(finding.file),
            "region": region(finding.file, finding.start, finding.end),
        }
    }
    if finding.subject is not None:
        kind, named = finding.subject.kind, finding.subject.name
        location["logicalLocations"] = [{"name": named, "kind": kind, "fullyQualifiedName": f"{kind}/{named}"}]
    return location


def _edits(finding: Finding, fix: Fix) -> Sequence[Edit]:
    """Return the edits of all places, in their order; those of the first where some touch."""
    every = {edit for place in finding.places if place.fix for edit in place.fix.edits}
    edits = sorted(every, key=lambda edit: edit.start)
    return fix.edits if any(a.end > b.start for a, b in pairwise(edits)) else edits


def _fix(finding: Finding, what: str, edits: Sequence[Edit], region: Region) -> Object:
    replacements = [
        {"deletedRegion": region(finding.file, edit.start, edit.end), "insertedContent": {"text": edit.text}}
        for edit in edits
    ]
    change = {"artifactLocation": _artifact(finding.file), "replacements": replacements}
    return {"description": {"text": what}, "artifactChanges": [change]}


def _places(reading: Document) -> SourcePositions:
    return SourcePositions(reading.data, reading.encoding)


def _region(places: SourcePositions, start: int, end: int) -> Object:
    first, last = places.span(start, start), places.span(end, end)
    return {"startLine": first.line, "startColumn": first.column, "endLine": last.line, "endColumn": last.column}


def _artifact(file: str) -> Object:
    """Return a relative path as it is, an absolute one as file:, standard input as a name."""
    if os.path.isabs(file):
        return {"uri": Path(file).as_uri()}
    return {"uri": quote(os.path.normpath(file).replace(os.sep, "/") if not file.startswith("<") else file)}
