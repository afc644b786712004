"""The `symbolic` executor: a program as SymPy expressions, one operation after another, nothing simplified."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from decimal import Decimal
from typing import Any

from robodyn.programs.program import Program
from robodyn.programs.scalar import ADD, COS, DIV, EXP, MUL, NEG, SIGN, SIN, SQRT, SUB
from robodyn.support.extras import need

DIGITS = 10
"""Decimals of up to so many digits count as short."""


def expressions(program: Program, symbols: Mapping[tuple[str, int], Any]) -> list[Any]:
    """Return the outputs of a program as SymPy expressions of its inputs, which are symbols or expressions."""
    return program.evaluated(lambda source, column: symbols[source, column], number, operations())


def number(value: float) -> Any:
    """Return a SymPy number: the rational that a short decimal stands for, else a float of 17 digits."""
    sympy = module()
    text = repr(float(value))
    if len(Decimal(text).normalize().as_tuple().digits) <= DIGITS:
        return sympy.Rational(text)
    return sympy.Float(float(value), 17)


def operations() -> dict[str, Callable[..., Any]]:
    sympy = module()
    return {
        ADD: sympy.Add,
        MUL: sympy.Mul,
        SUB: lambda a, b: a - b,
        DIV: lambda a, b: a / b,
        NEG: lambda a: -a,
        SQRT: sympy.sqrt,
        SIN: sympy.sin,
        COS: sympy.cos,
        SIGN: sympy.sign,
        EXP: sympy.exp,
    }


def module() -> Any:
    """SymPy; an InputError where it is not installed."""
    try:
        import sympy
    except ImportError:
        need("closed forms", "sympy")
        raise
    return sympy
