"""`robodyn rule`: what a rule of `robodyn check` asks for, and why."""

from __future__ import annotations

from collections.abc import Sequence

import click

from robodyn.checks.catalogue import RULES, instead_of
from robodyn.checks.rule import Rule
from robodyn.cli.options import option
from robodyn.cli.screen import page, show
from robodyn.errors import InputError
from robodyn.report.check import rules_sections
from robodyn.report.document import text
from robodyn.support.wording import shown


@click.command("rule", short_help="Explain the rules of check.")
@click.argument("asked", nargs=-1, metavar="CODE|WORD...")
@option("--all", "Every rule.", name="everything")
def command(asked: tuple[str, ...], everything: bool) -> None:
    """Explain rules of `robodyn check`, by codes or names, each with a bad and a good example; or list those whose
    codes begin so, or whose documentation has a word. Without either, list them all.

    \b
    Examples:
      robodyn rule RD207
      robodyn rule inertia
    """
    found = {word: found_by(word, RULES) for word in asked}
    for word, rules in found.items():
        if not rules:
            raise InputError(f"no rule has the code or the word {shown(word)}", remedy=instead_of(word, RULES))
    chosen = RULES if everything or not asked else [rule for rules in found.values() for rule in rules]
    if everything or (asked and all(len(rules) == 1 for rules in found.values())):
        show(text(rules_sections(chosen), page()))
    else:
        for rule in dict.fromkeys(chosen):
            off = "" if rule.in_default else " (off unless selected)"
            show(f"{rule.code} {rule.severity.value:7} {rule.summary}{off}\n")


def found_by(text: str, rules: Sequence[Rule]) -> tuple[Rule, ...]:
    """Return the rule of this code or name, or those whose codes begin so, or in whose documentation it stands: in name
    or summary before those that have it in their explanation."""
    exact = tuple(rule for rule in rules if text.upper() == rule.code or text.lower() == rule.name)
    if exact or not text.strip():
        return exact
    begun = tuple(rule for rule in rules if rule.code.startswith(text.upper()))
    if begun:
        return begun
    word = text.casefold()
    titled = [rule for rule in rules if word in f"{rule.name} {rule.summary}".casefold()]
    explained = [rule for rule in rules if rule not in titled and word in " ".join(rule.explanation.split()).casefold()]
    return (*titled, *explained)
