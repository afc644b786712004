"""Every rule's documentation is true: its bad example is found, its good one is not."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from robodyn.checks.catalogue import RULES
from robodyn.checks.check import check_one
from robodyn.checks.examples import arm
from robodyn.checks.rule import Finding, Rule, Severity

BOX = '<collision><geometry><box size="0.1 0.1 0.25"/></geometry></collision>'
CODES = [rule.code for rule in RULES]
ASKING = ("RD802", "RD902", "RD602", "RD604", "RD605", "RD607", "RD624")
ABOUT_SRDF = ("RD706", "RD707", "RD708", "RD709")
ALONE = [rule for rule in RULES if rule.code not in (*ASKING, *ABOUT_SRDF)]
"""The rules that need nothing but the file; test_asked and test_mesh_rules give the others what they ask for."""
SRDF = [rule for rule in RULES if rule.code in ABOUT_SRDF]
DESCRIPTIONS = [rule for rule in RULES if rule.code not in ABOUT_SRDF]
SHAPED_ARM = (
    arm().replace('<link name="base"/>', f'<link name="base">{BOX}</link>').replace("</inertial>", f"</inertial>{BOX}")
)


def found(text: str) -> tuple[Finding, ...]:
    return check_one(text.encode())


def test_codes_and_names_are_unique_and_in_order() -> None:
    assert sorted(set(CODES)) == CODES
    assert len({rule.name for rule in RULES}) == len(RULES)


@pytest.mark.parametrize("rule", ALONE, ids=lambda rule: rule.code)
def test_bad_example_is_found_by_this_rule_and_raises_no_other_error(rule: Rule) -> None:
    findings = found(rule.bad)
    assert (rule.code, rule.name) in {(finding.code, finding.name) for finding in findings}
    assert {finding.code for finding in findings if finding.severity is Severity.ERROR} <= {rule.code}


@pytest.mark.parametrize("rule", SRDF, ids=lambda rule: rule.code)
def test_examples_that_are_srdfs(rule: Rule, tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    file.write_text(SHAPED_ARM)
    for text, times in ((rule.bad, 1), (rule.good, 0)):
        (tmp_path / "arm.srdf").write_text(text)
        findings = [finding for finding in check_one(str(file)) if finding.code == rule.code]
        assert len(findings) == times
        assert all(finding.file == str(tmp_path / "arm.srdf") for finding in findings)


@pytest.mark.parametrize("rule", DESCRIPTIONS, ids=lambda rule: rule.code)
def test_good_example_is_not_found_and_has_no_error(rule: Rule) -> None:
    findings = found(rule.good)
    assert rule.code not in {finding.code for finding in findings}
    assert not [finding for finding in findings if finding.severity is Severity.ERROR]


def test_documentation_is_complete() -> None:
    for rule in RULES:
        assert re.fullmatch(r"RD\d{3}", rule.code)
        assert re.fullmatch(r"[a-z]+(-[a-z]+)*", rule.name)
        assert rule.summary.endswith(".")
        assert ". " not in rule.summary, "one sentence"
        assert rule.explanation.endswith(".")
        assert rule.check.__module__.startswith("robodyn.checks.rules.")
