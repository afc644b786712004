"""A program as statements of a language, one per operation: all that is written for others comes from here."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import count
from typing import NamedTuple

from robodyn.errors import InputError
from robodyn.programs.program import Program
from robodyn.programs.scalar import ADD, CONSTANT, COS, DIV, EXP, INPUT, MUL, NEG, SIGN, SIN, SQRT, SUB

ARITHMETIC = {
    ADD: "{} + {}",
    SUB: "{} - {}",
    MUL: "{} * {}",
    DIV: "{} / {}",
    NEG: "-{}",
    SQRT: "sqrt({})",
    SIN: "sin({})",
    COS: "cos({})",
    EXP: "exp({})",
    SIGN: "sign({})",
}
"""Each operation on operands that are names or numbers."""


class Language(NamedTuple):
    """How operations are written.

    Attributes:
        statement: gives a value a name.
        forms: each operation.
        reuses: whether a name can be given again, to another value, when the first is needed no more: in a language of
            arrays, that frees memory.
    """

    statement: str
    forms: Mapping[str, str] = ARITHMETIC
    reuses: bool = False


def statements(program: Program, language: Language) -> tuple[list[str], list[str]]:
    """Return a statement per operation, in the program's order, and the operand that each output is.

    Inputs are written as `q[0]`, numbers with all their digits.

    Raises:
        InputError: a constant of the program is not finite.
    """
    last = _last_uses(program)
    lines: list[str] = []
    written: list[str] = []
    free: list[str] = []
    names = map("t{}".format, count())
    for k, (op, a, b) in enumerate(program.operations):
        if op is INPUT:
            written.append(f"{a}[{b}]")
        elif op is CONSTANT:
            written.append(literal(a))
        else:
            operands = (a,) if b is None else (a, b)
            value = language.forms[op].format(*(written[i] for i in operands))
            if language.reuses:
                free += [written[i] for i in dict.fromkeys(operands) if last[i] == k and _has_name(program, i)]
            written.append(free.pop() if free else next(names))
            lines.append(language.statement.format(written[k], value))
    return lines, [written[i] for i in program.outputs]


def literal(value: float) -> str:
    """Return the number as Python and C write it.

    Raises:
        InputError: it is not finite.
    """
    if not math.isfinite(value):
        raise InputError("a constant of the equations overflows", remedy="check the masses, lengths and gravity")
    return repr(value)


def _has_name(program: Program, place: int) -> bool:
    return program.operations[place][0] not in (INPUT, CONSTANT)


def _last_uses(program: Program) -> dict[int, int]:
    """Return the operation after which each value is needed no more; outputs always are."""
    uses = {i: k for k, (op, a, b) in enumerate(program.operations) if op not in (INPUT, CONSTANT) for i in (a, b)}
    return {**uses, **dict.fromkeys(program.outputs, len(program.operations))}
