"""Every rule, in the order of the codes: a new one is a file in `rules/`."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from robodyn.checks import rules
from robodyn.checks.rule import Rule

_FILES = sorted(name for _, name, _ in iter_modules(rules.__path__, f"{rules.__name__}."))
RULES: tuple[Rule, ...] = tuple(import_module(name).RULE for name in _FILES)
CODES = tuple(rule.code for rule in RULES)
