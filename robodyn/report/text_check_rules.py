"""The documentation of the rules of `robodyn check` as text."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill, indent

from robodyn.checks.rule import Rule, Severity

_WIDTH = 100
_WEIGHT = {
    Severity.ERROR: "error: the check fails",
    Severity.WARNING: "warning: the check fails with --strict",
    Severity.NOTE: "note: the check does not fail",
}


def rules_text(rules: Sequence[Rule]) -> str:
    """What each rule asks for, why, and an example of both."""
    return "\n".join(map(_rule, rules))


def _rule(rule: Rule) -> str:
    return (
        f"{rule.code} {rule.name} ({_WEIGHT[rule.severity]})\n\n"
        f"{fill(rule.summary, _WIDTH)}\n\n{fill(' '.join(rule.explanation.split()), _WIDTH)}\n\n"
        f"bad:\n{indent(rule.bad, '    ')}\ngood:\n{indent(rule.good, '    ')}"
    )
