"""`robodyn rule`: what a rule of `robodyn check` asks for, and why."""

from __future__ import annotations

import click

from robodyn.checks.catalogue import RULES
from robodyn.cli.screen import show
from robodyn.errors import InputError
from robodyn.report.text_check_rules import rules_text
from robodyn.wording import alternatives, shown


@click.command("rule", short_help="Explain the rules of check.")
@click.argument("codes", nargs=-1, metavar="CODE...")
@click.option("--all", "everything", is_flag=True, help="Every rule.")
def command(codes: tuple[str, ...], everything: bool) -> None:
    """Explain rules of `robodyn check`, each with a bad and a good example.
    Without a code, list them.

    \b
    Example:
      robodyn rule RD207
    """
    known = {key: rule for rule in RULES for key in (rule.code, rule.name)}
    for code in codes:
        if code not in known and code.upper() not in known:
            raise InputError(f"there is no rule {shown(code)}", remedy=alternatives(code.upper(), known, "rules"))
    chosen = RULES if everything else [known.get(code) or known[code.upper()] for code in codes]
    if chosen:
        show(rules_text(chosen))
    else:
        show("".join(f"{rule.code} {rule.severity.value:7} {rule.summary}\n" for rule in RULES))
