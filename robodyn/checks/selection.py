"""Which rules run, and which of their findings are shown."""

from __future__ import annotations

from collections.abc import Callable

from robodyn.checks.catalogue import CODES, RULES, instead_of
from robodyn.checks.context import Asked
from robodyn.checks.finding import Finding
from robodyn.checks.rule import Rule
from robodyn.errors import InputError
from robodyn.support.wording import shown

ALL, DEFAULT = "ALL", "DEFAULT"
WORDS = (ALL, DEFAULT)
"""What may be selected beside codes: every finding of every rule; those that are errors or likely defects."""
BY_CODE = {rule.code: rule for rule in RULES}

Codes = tuple[str, ...]


def rules_for(select: Codes, ignore: Codes) -> tuple[Rule, ...]:
    """Return the rules that are selected and not ignored; all if nothing is selected.

    Raises:
        InputError: no rule has such a code.
    """
    for given in (*(code for code in select if code not in WORDS), *ignore):
        if not given or not any(code.startswith(given) for code in CODES):
            raise InputError(f"there is no rule {shown(given)}", remedy=instead_of(given, RULES))
    wanted = ("",) if not select or {*WORDS} & {*select} else select
    return tuple(rule for rule in RULES if rule.code.startswith(wanted) and not rule.code.startswith(ignore))


def shown_of(select: Codes, asked: Asked) -> Callable[[Finding], bool]:
    """Return whether a finding is shown: it is selected by code or ALL, or asked for, or in the default set."""
    codes = (*(code for code in select if code not in WORDS), *_asked_for(asked))
    default = not select or DEFAULT in select

    def is_shown(finding: Finding) -> bool:
        in_default = default and finding.severity.reaches(BY_CODE[finding.code].default)
        return in_default or ALL in select or finding.code.startswith(codes)

    return is_shown


def _asked_for(asked: Asked) -> Codes:
    """Return the rules whose findings an option asks for."""
    given = ((asked.trajectory, ("RD802",)), (asked.targets, ("RD607", "RD901")), (asked.against, ("RD902",)))
    return tuple(code for value, codes in given if value for code in codes)
