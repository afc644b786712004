"""What the rules find in one file, every place by itself."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

from robodyn.checks.context import Context
from robodyn.checks.groups import kind_of
from robodyn.checks.rule import HERE, Fault, Finding, Rule, excerpt
from robodyn.checks.rules import rd009_unused_waiver as unused_waiver
from robodyn.checks.waivers import waived, waivers
from robodyn.robot.urdf.view import Subject


def every_place(context: Context, rules: Sequence[Rule]) -> tuple[Finding, ...]:
    """Return what these rules find and no waiver of the file allows, in the order of the text."""
    ready = [rule for rule in rules if context.reaches(rule.stage)]
    findings = [_finding(context, rule, fault) for rule in ready for fault in rule.check(context)]
    left = _without_waived(context, ready, findings)
    return tuple(sorted(left, key=lambda finding: (finding.start, finding.code)))


def _without_waived(context: Context, rules: Sequence[Rule], findings: list[Finding]) -> list[Finding]:
    """Return the findings that no waiver of the file allows, and those about waivers that had nothing to allow."""
    given = [waiver for waiver in context.once(waivers) if waiver.in_force(context.codes)]
    if not given:
        return findings
    ran = {rule.code for rule in rules}
    left, unused = waived(context.reading, findings, given)
    if unused_waiver.check.code in ran:
        faults = [unused_waiver.unused(waiver, code) for waiver, code in unused if code in ran]
        left += [_finding(context, unused_waiver.check, fault) for fault in faults]
    return left


def _finding(context: Context, rule: Rule, fault: Fault) -> Finding:
    reading, subject = fault.document or context.reading, fault.subject
    if subject is HERE:
        subject = _part_at(context, fault.at.start)
    return Finding(
        code=rule.code,
        name=rule.name,
        severity=fault.severity or rule.severity,
        file=reading.file,
        line=fault.at.line,
        column=fault.at.column,
        start=fault.at.start,
        end=fault.at.end,
        subject=subject,
        message=fault.what if subject is None else f"{subject.words}: {fault.what}",
        remedy=fault.remedy,
        measured=fault.measured,
        bound=fault.bound,
        cause=fault.cause,
        fix=fault.fix,
        excerpt=excerpt(reading, fault.at),
        kind=fault.kind or kind_of(fault.what),
        description=None if fault.document is None else context.reading.file,
    )


def _part_at(context: Context, start: int) -> Subject | None:
    """Return the link or joint that this byte of the text is in."""
    parts = context.reading.root.children
    k = bisect_right(parts, start, key=lambda part: part.start) - 1
    return Subject(parts[k].tag, parts[k].get("name") or "") if k >= 0 and parts[k].tag in ("link", "joint") else None
