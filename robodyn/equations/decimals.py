"""Expressions with decimals for people, in place of fractions of large integers."""

from __future__ import annotations

from typing import Any

from robodyn.programs.run.symbolic import module


def decimal(expression: Any) -> Any:
    """The same expression with floats of 17 digits for its fractions; exponents stay."""
    sympy = module()
    if expression.is_Rational:
        return expression if expression.is_Integer else sympy.Float(expression, 17)
    if expression.is_Pow:
        return sympy.Pow(decimal(expression.base), expression.exp)
    return expression.func(*map(decimal, expression.args)) if expression.args else expression
