"""Findings as one JSON document with stable keys."""

from __future__ import annotations

from typing import Any

from robodyn.checks.rule import Finding, Fix
from robodyn.checks.run import Checked
from robodyn.report.check_words import check_data


def check_json(checked: Checked) -> str:
    """The document: {"findings": [...], "unread": [...], "summary": {...}}.

    Places count from 1; edits are byte offsets of the file.
    """
    import json

    summary = {"files": len(checked.files), **check_data(checked)}
    document = {
        "findings": [_finding(finding) for finding in checked.findings],
        "unread": [{"file": each.file, "error": each.why} for each in checked.unread],
        "summary": summary,
    }
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def _finding(finding: Finding) -> dict[str, Any]:
    subject = finding.subject
    return {
        "file": finding.file,
        "line": finding.line,
        "column": finding.column,
        "code": finding.code,
        "name": finding.name,
        "severity": finding.severity.value,
        "subject": None if subject is None else {"kind": subject.kind, "name": subject.name},
        "message": finding.message,
        "remedy": finding.remedy,
        "measured": _finite(finding.measured),
        "bound": _finite(finding.bound),
        "cause": finding.cause,
        "fix": None if finding.fix is None else _fix(finding.fix),
    }


def _fix(fix: Fix) -> dict[str, Any]:
    edits = [{"start": edit.start, "end": edit.end, "text": edit.text} for edit in fix.edits]
    return {"what": fix.what, "safe": fix.safe, "edits": edits}


def _finite(value: float | None) -> float | None:
    return value if value is not None and abs(value) < float("inf") else None
