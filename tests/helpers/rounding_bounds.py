"""How far from the exact value a program's outputs may be when each operation is rounded: running error analysis.

N. J. Higham, "Accuracy and Stability of Numerical Algorithms", 2nd edition, section 3.3, here with every term of second
order kept, so that the bound holds however large the errors are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from mpmath import isfinite, isnan

from robodyn.programs.run.multiprecision import Multiprecision
from robodyn.programs.scalar import ADD, CONSTANT, COS, DIV, EXP, INPUT, MUL, NEG, SIGN, SIN, SQRT, SUB

DIGITS = 60
ROUNDED, ELEMENTARY = {ADD, SUB, MUL, DIV, SQRT}, {SIN, COS, EXP}
SLACK = 1.0 + 1e-9
"""For the roundings of the bound itself, and of the exact values."""


@dataclass(frozen=True)
class Bounds:
    """Exact outputs (samples, outputs) and the largest error of each, inf where nothing can be said."""

    exact: Any
    error: Any

    @property
    def known(self):
        """Where the bound is finite, or the output is nan or infinite for certain."""
        return self.error < np.inf

    def broken(self, found):
        """(sample, output, found, exact, error) of what lies outside; sample k is held against exact sample k modulo
        their number.
        """
        out = []
        for k, row in enumerate(np.asarray(found)):
            at = k % len(self.exact)
            for j, value in enumerate(row.tolist()):
                if not _holds(value, self.exact[at, j], self.error[at, j]):
                    out.append((k, j, value, self.exact[at, j], self.error[at, j]))
        return out


def _holds(value, exact, error):
    if error == np.inf:
        return True
    if isnan(exact):
        return isnan(value)
    return value == exact or abs(value - exact) <= error * SLACK


def exactly(program, sources, samples):
    """The exact values of every operation, and the context that they are numbers of."""
    every = Multiprecision(replace(program, outputs=tuple(range(len(program.operations)))), digits=DIGITS)
    return every.context, every(sources, samples)


def bounds(program, sources, samples, dtype=np.float64, ulps=1, exact=None):
    """What every executor keeps that rounds each operation once in the format `dtype`, sine, cosine and exponential to
    so many units in the last place; a fused multiply-add in place of a product and a sum is no worse.

    Args:
        sources: arrays of doubles; they and the constants are rounded to `dtype` first.
        exact: what `exactly` returns for these sources, if that is at hand.
    """
    context, values = exact or exactly(program, sources, samples)
    errors = [_errors(context, program, row, dtype, ulps) for row in values]
    outputs = list(program.outputs)
    return Bounds(values[:, outputs], np.array(errors, dtype=object).reshape(values.shape)[:, outputs])


def _errors(context, program, values, dtype, ulps):
    """The error bound of each value of one sample."""
    errors = []
    for (op, a, b), y in zip(program.operations, values, strict=True):
        if op in (INPUT, CONSTANT):
            errors.append(_of_leaf(context, y, dtype))
            continue
        operands = [(values[k], errors[k]) for k in (a, b) if k is not None]
        ulp = ulps if op in ELEMENTARY else 0.5 if op in ROUNDED else 0
        errors.append(_of_operation(context, op, y, operands, ulp, np.finfo(dtype)))
    return errors


def _of_leaf(context, y, dtype):
    with np.errstate(all="ignore"):
        rounded = float(dtype(float(y)))
    return context.zero if rounded == y or isnan(y) else abs(context.convert(rounded) - y)


def _of_operation(context, op, y, operands, ulps, info):
    if any(error == np.inf for _, error in operands):
        return context.inf
    if any(isnan(x) for x, _ in operands):
        return context.zero
    if not all(isfinite(x) for x in (y, *(x for x, _ in operands))):
        signless = op is DIV and operands[1][0] == 0 and not isnan(y)
        steady = all(error == 0 or abs(x) > error for x, error in operands)
        return context.zero if steady and not signless else context.inf
    flat = [number for operand in operands for number in operand]
    return _rounded(context, y, PROPAGATION[op](context, y, *flat), ulps, info)


def _rounded(context, y, error, ulps, info):
    """The error with the rounding of a result within `error` of y; a unit in the last place is at most eps of it."""
    if ulps and abs(y) + error > 0:
        below = abs(y) - error < float(info.smallest_normal)
        error += ulps * float(info.eps) * (abs(y) + error)
        error += ulps * context.mpf(float(info.smallest_subnormal)) if below else 0
    return context.inf if abs(y) + error > float(info.max) else error


def _quotient(context, y, _, ea, b, eb):
    return (ea + abs(y) * eb) / (abs(b) - eb) if abs(b) > eb else context.inf


def _root(context, y, a, ea):
    if ea == 0:
        return ea
    return ea / (y + context.sqrt(a - ea)) if a >= ea else context.inf


def _sum(_context, _y, _a, ea, _b, eb):
    return ea + eb


def _wave(context, _y, _a, ea):
    return min(ea, context.mpf(2))


PROPAGATION = {
    ADD: _sum,
    SUB: _sum,
    MUL: lambda _context, _y, a, ea, b, eb: abs(a) * eb + abs(b) * ea + ea * eb,
    DIV: _quotient,
    NEG: lambda _context, _y, _a, ea: ea,
    SQRT: _root,
    SIN: _wave,
    COS: _wave,
    SIGN: lambda context, y, a, ea: context.zero if ea == 0 or abs(a) > ea else 1 + abs(y),
    EXP: lambda context, y, _a, ea: y * context.expm1(ea),
}
"""How far the exact operation moves when its operands a, b are wrong by up to ea, eb; y is its value where they are
right.
"""
