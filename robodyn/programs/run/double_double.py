"""The double-double executor: a program on pairs of floats whose sum has twice the digits of a float.

Sums and products of floats are split without error into a rounded part and the rest (T. J. Dekker, Numerische
Mathematik 18, 1971; Y. Hida, X. Li, D. Bailey, "Library for double-double and quad-double arithmetic", 2007).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from math import factorial
from typing import Any, NamedTuple

import numpy as np

from robodyn.programs.program import Program
from robodyn.programs.scalar import ADD, COS, DIV, EXP, MUL, NEG, SIGN, SIN, SQRT, SUB
from robodyn.support.floats import Floats

BLOCK = 1024
"""Samples at a time: all intermediate results stay in the cache."""
TERMS = 28
"""Of power series, up to pi/4: the first that is left out is below 1e-33."""
_SPLIT = 134217729.0  # 2^27 + 1
_HALF_PI = 1.5707963267948966, 6.123233995736766e-17, -1.4973849048591833e-33
_LN_2 = 0.6931471805599453, 2.3190468138462996e-17, 5.707708438416212e-34


class Pair(NamedTuple):
    """Numbers `high + low`, low being at most half a unit in the last place of high."""

    high: Any
    low: Any


@np.errstate(all="ignore")
def double_double(program: Program, sources: Mapping[str, Floats], samples: int) -> Pair:
    """Return the outputs of a program for arrays (samples, columns): two (samples, outputs) whose sum they are.

    Accuracy: each operation is right to 1e-31 of its result, sine and cosine to 1e-31, for arguments up to 1e6;
        products of more than 1e300 are nan.
    """
    found = Pair(*(np.empty((samples, len(program.outputs))) for _ in range(2)))
    for start in range(0, samples, BLOCK):
        block = slice(start, start + BLOCK)

        def column(source: str, index: int, block: slice = block) -> Pair:
            values = np.ascontiguousarray(sources[source][block, index])
            return Pair(values, np.zeros(len(values)))

        for k, x in enumerate(program.evaluated(column, lambda value: Pair(value, 0.0), _FUNCTIONS)):
            found.high[block, k], found.low[block, k] = x
    return found


def added(a: Pair, b: Pair) -> Pair:
    s, e = _two_sum(a.high, b.high)
    t, f = _two_sum(a.low, b.low)
    s, e = _fast_two_sum(s, e + t)
    return _fast_two_sum(s, e + f)


def subtracted(a: Pair, b: Pair) -> Pair:
    return added(a, negated(b))


def multiplied(a: Pair, b: Pair) -> Pair:
    p, e = _two_product(a.high, b.high)
    return _fast_two_sum(p, e + (a.high * b.low + a.low * b.high))


def divided(a: Pair, b: Pair) -> Pair:
    """Long division in three digits, each a float."""
    first = a.high / b.high
    rest = subtracted(a, multiplied(b, Pair(first, 0.0)))
    second = rest.high / b.high
    rest = subtracted(rest, multiplied(b, Pair(second, 0.0)))
    quotient = added(_fast_two_sum(first, second), Pair(rest.high / b.high, 0.0))
    whole = np.isfinite(first)
    return Pair(np.where(whole, quotient.high, first), np.where(whole, quotient.low, 0.0))


def negated(a: Pair) -> Pair:
    return Pair(-a.high, -a.low)


def root(a: Pair) -> Pair:
    """Newton's step from the root of the high part (A. H. Karp, P. Markstein, 1997)."""
    near = np.sqrt(a.high)
    rest = subtracted(a, _two_product(near, near))
    safe = np.where(near == 0.0, 1.0, near)
    return _fast_two_sum(near, rest.high / (2.0 * safe))


def sine(a: Pair, ahead: int = 0) -> Pair:
    """Return the sine `ahead` quarter turns further."""
    turns = np.rint(a.high / _HALF_PI[0])
    r = _reduced(a, turns, _HALF_PI)
    square = multiplied(r, r)
    s = multiplied(r, _polynomial(square, _inverse_factorials(1, 2)))
    c = _polynomial(square, _inverse_factorials(0, 2))
    quadrant = np.mod(turns + ahead, 4.0)
    even, flip = np.mod(quadrant, 2.0) == 0.0, np.where(quadrant >= 2.0, -1.0, 1.0)
    return Pair(*(flip * np.where(even, x, y) for x, y in zip(s, c, strict=True)))


def exponential(a: Pair) -> Pair:
    turns = np.rint(a.high / _LN_2[0])
    total = _polynomial(_reduced(a, turns, _LN_2), _inverse_factorials(0, 1))
    whole = turns.astype(np.int64) if np.ndim(turns) else int(turns)
    return Pair(np.ldexp(total.high, whole), np.ldexp(total.low, whole))


_FUNCTIONS: dict[str, Callable[..., Pair]] = {
    ADD: added,
    SUB: subtracted,
    MUL: multiplied,
    DIV: divided,
    NEG: negated,
    SQRT: root,
    SIN: sine,
    COS: lambda a: sine(a, 1),
    EXP: exponential,
    SIGN: lambda a: Pair(np.sign(a.high), 0.0 * a.high),
}


def _two_sum(a: Any, b: Any) -> Pair:
    s = a + b
    t = s - a
    return Pair(s, (a - (s - t)) + (b - t))


def _fast_two_sum(a: Any, b: Any) -> Pair:
    """For |a| >= |b|."""
    s = a + b
    return Pair(s, b - (s - a))


def _two_product(a: Any, b: Any) -> Pair:
    p = a * b
    s, t = _SPLIT * a, _SPLIT * b
    u, x = s - (s - a), t - (t - b)
    v, y = a - u, b - x
    return Pair(p, ((u * x - p) + u * y + v * x) + v * y)


def _reduced(a: Pair, turns: Any, period: Sequence[float]) -> Pair:
    """a less a whole number of periods, which are known to three floats."""
    for part in period:
        a = subtracted(a, _two_product(turns, part))
    return a


def _polynomial(x: Pair, coefficients: Sequence[Pair]) -> Pair:
    total = coefficients[-1]
    for coefficient in coefficients[-2::-1]:
        total = added(multiplied(total, x), coefficient)
    return total


@lru_cache(maxsize=8)
def _inverse_factorials(first: int, step: int) -> tuple[Pair, ...]:
    """Of first, first + step and so on; of step 2 with alternating signs."""
    from fractions import Fraction

    found = []
    for k in range(first, TERMS, step):
        exact = Fraction(-1 if step == 2 and (k - first) % 4 else 1, factorial(k))
        high = float(exact)
        found.append(Pair(high, float(exact - Fraction(high))))
    return tuple(found)
