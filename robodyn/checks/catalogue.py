"""Every rule, in the order of the codes: which one is meant, which run, which of their findings are shown."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pkgutil import iter_modules

from robodyn.checks import rules
from robodyn.checks.context import Asked
from robodyn.checks.rule import Finding, Rule
from robodyn.errors import InputError
from robodyn.support.wording import nearest, shown

_FAMILIES = [import_module(name) for _, name, _ in iter_modules(rules.__path__, f"{rules.__name__}.")]
_FOUND = [one for family in _FAMILIES for one in vars(family).values() if isinstance(one, Rule)]
RULES: tuple[Rule, ...] = tuple(sorted(_FOUND, key=lambda rule: rule.code))
CODES = tuple(rule.code for rule in RULES)
_LEAST = 3  # characters of a code that say of which kind a rule is: RD2
ALL, DEFAULT = "ALL", "DEFAULT"
WORDS = (ALL, DEFAULT)
"""What may be selected beside codes: every finding of every rule; those that are errors or likely defects."""
BY_CODE = {rule.code: rule for rule in RULES}
Codes = tuple[str, ...]


def instead_of(given: str, rules: Sequence[Rule]) -> str:
    """What may stand in place of a code that no rule has and none begins with."""
    codes = [rule.code for rule in rules]
    for rule in rules:
        if rule.name == given.lower():
            return f"{shown(rule.name)} is {rule.code}"
    for length in range(len(given), _LEAST - 1, -1):
        begun = [code for code in codes if code.startswith(given[:length].upper())]
        if begun:
            return f"{given[:length].upper()} means {begun[0]} to {begun[-1]}"
    near = nearest(given, codes)
    if near:
        return f"did you mean {shown(near[0])}?"
    return "give codes such as RD207, or their beginnings such as RD2; robodyn rule WORD finds them"


def rules_for(select: Codes, ignore: Codes) -> tuple[Rule, ...]:
    """Return the rules that are selected and not ignored; all if nothing is selected. InputError for unknown codes."""
    for given in (*(code for code in select if code not in WORDS), *ignore):
        if not given or not any(code.startswith(given) for code in CODES):
            raise InputError(f"there is no rule {shown(given)}", remedy=instead_of(given, RULES))
    wanted = ("",) if not select or {*WORDS} & {*select} else select
    return tuple(rule for rule in RULES if rule.code.startswith(wanted) and not rule.code.startswith(ignore))


def is_selected(finding: Finding, select: Codes, asked: Asked) -> bool:
    """Whether a finding is shown: it is selected by code or ALL, or asked for, or in the default set."""
    in_default = finding.severity.reaches(BY_CODE[finding.code].default) and (not select or DEFAULT in select)
    codes = tuple(code for code in select if code not in WORDS)
    given = ((asked.trajectory, ("RD802",)), (asked.targets, ("RD607", "RD901")), (asked.against, ("RD902",)))
    asked_for = [code for value, codes in given if value for code in codes]
    return in_default or ALL in select or finding.code.startswith((*codes, *asked_for))
