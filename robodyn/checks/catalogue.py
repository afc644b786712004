"""Every rule, in the order of the codes, and how one is found: a new one is a file in `rules/`."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pkgutil import iter_modules

from robodyn.checks import rules
from robodyn.checks.rule import Rule
from robodyn.support.wording import nearest, shown

_FILES = sorted(name for _, name, _ in iter_modules(rules.__path__, f"{rules.__name__}."))
RULES: tuple[Rule, ...] = tuple(import_module(name).check for name in _FILES)
CODES = tuple(rule.code for rule in RULES)

_LEAST = 3
"""Characters of a code that say of which kind a rule is: RD2."""


def found_by(text: str, rules: Sequence[Rule]) -> tuple[Rule, ...]:
    """Return the rule of this code or name, or those whose codes begin so, or in whose documentation it stands.

    Rules that have it in their name or summary come before those that have it in their explanation.
    """
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


def instead_of(given: str, rules: Sequence[Rule]) -> str:
    """Return what may stand in place of a code that no rule has and none begins with."""
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
