"""The rules of `robodyn check`: their documentation, and how often each has found something."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from textwrap import fill, indent

from robodyn.checks.rule import Finding, Rule, Severity
from robodyn.report.table import PLAIN, Page

_WIDTH = 100
_WEIGHT = {
    Severity.ERROR: "error: the check fails",
    Severity.WARNING: "warning: the check fails with --strict",
    Severity.NOTE: "note: the check does not fail",
}


def rules_text(rules: Sequence[Rule]) -> str:
    """Return what each rule asks for, why, and an example of both."""
    return "\n".join(map(_rule, rules))


def _rule(rule: Rule) -> str:
    return (
        f"{rule.code} {rule.name} ({_WEIGHT[rule.severity]})\n\n"
        f"{fill(rule.summary, _WIDTH)}\n\n{fill(' '.join(rule.explanation.split()), _WIDTH)}\n\n"
        f"bad:\n{indent(rule.bad, '    ')}\ngood:\n{indent(rule.good, '    ')}"
    )


def check_statistics(findings: Sequence[Finding], page: Page = PLAIN) -> str:
    """Return a table of rules, the most frequent first: findings, files, and how many have safe and other fixes."""
    count = Counter(finding.code for finding in findings)
    files = Counter(code for code, _ in {(finding.code, finding.file) for finding in findings})
    safe = Counter(finding.code for finding in findings if finding.fix and finding.fix.safe)
    unsafe = Counter(finding.code for finding in findings if finding.fix and not finding.fix.safe)
    names = {finding.code: f"{finding.code} {finding.name}" for finding in findings}
    if not count:
        return "no findings\n"
    order = sorted(count, key=lambda code: (-count[code], code))
    rows = [[names[code], *(_figure(tally[code]) for tally in (count, files, safe, unsafe))] for code in order]
    return page.table((("rule", "findings", "files", "safe fixes", "unsafe fixes"), rows))


def _figure(count: int) -> str:
    return str(count) if count else "-"
