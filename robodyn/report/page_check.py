"""The findings of `check` as a report for people."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import PurePath

from robodyn.checks.rule import Finding
from robodyn.checks.run import Checked
from robodyn.report.check_words import LEVELS, check_verdict
from robodyn.report.document import (
    Block,
    Document,
    Download,
    Facts,
    Findings,
    Heading,
    Level,
    Table,
    Verdict,
    downloads,
)
from robodyn.report.json.descriptions import check_json
from robodyn.report.table import printable
from robodyn.report.text_check import marked


def check_page(checked: Checked) -> Document:
    """Whether the descriptions can be used, which rules speak and how often, and every finding with its line."""
    count = f"{len(checked.files)} file{'' if len(checked.files) == 1 else 's'} checked"
    blocks: list[Block] = [_verdict(checked)]
    if checked.findings:
        blocks += [_facts(checked), Heading("Rules"), _rules(checked)]
    for file in checked.files:
        found = [finding for finding in checked.findings if finding.file == file]
        if found:
            blocks += [Heading(printable(file)), Findings(tuple(map(_item, found)))]
    blocks += [Heading("Data"), downloads([Download("findings.json", "application/json", check_json(checked))], _HOW)]
    title = PurePath(checked.files[0]).name if len(checked.files) == 1 else "Robot descriptions"
    return Document(title, f"Check of robot descriptions: {count}", tuple(blocks))


_HOW = "robodyn check --format json prints it"


def _verdict(checked: Checked) -> Verdict:
    found = check_verdict(checked)
    fixes = sum(finding.fix is not None and finding.fix.safe for finding in checked.findings)
    if not fixes:
        return found
    correct = f"robodyn check --fix corrects {fixes} of the findings and leaves the dynamics as they are."
    return replace(found, reasons=(*found.reasons, correct))


def _facts(checked: Checked) -> Facts:
    clean = len(set(checked.files) - {finding.file for finding in checked.findings})
    counts = [(f"{severity.value}s".capitalize(), str(checked.count(severity)), "") for severity in LEVELS]
    return Facts((*counts, ("Files without a finding", f"{clean} of {len(checked.files)}", "")))


def _rules(checked: Checked) -> Table:
    counts = Counter((finding.code, finding.name, finding.severity) for finding in checked.findings)
    order = list(LEVELS)
    ranked = sorted(counts.items(), key=lambda item: (order.index(item[0][2]), -item[1], item[0][0]))
    rows = [(code, name, severity.value, str(count)) for (code, name, severity), count in ranked]
    return Table("How often each rule speaks", ("code", "rule", "severity", "findings"), rows, _EXPLAINED)


_EXPLAINED = "robodyn rule CODE explains a rule."


def _item(finding: Finding) -> tuple[Level, str, tuple[tuple[str, bool], ...]]:
    title = f"Line {finding.line}: {finding.message} ({finding.severity.value} {finding.code} {finding.name})"
    lines = [("\n".join(marked(finding.line, finding.excerpt)), True)] if finding.excerpt.text else []
    if finding.cause is not None:
        lines.append((f"Cause: {finding.cause}.", False))
    lines.append((f"To do: {finding.remedy}.", False))
    if finding.fix is not None:
        lines.append((f"Fix ({'safe' if finding.fix.safe else 'unsafe'}): {finding.fix.what}.", False))
    return LEVELS[finding.severity], title, tuple(lines)
