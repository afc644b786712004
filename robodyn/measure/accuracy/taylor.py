"""Power series of the solution of `y' = f(y)`, f being a program, in integers: as many digits as asked.

A number x stands as the integer nearest below x 2^BITS, so sums are exact and a product is rounded once. The
coefficients of a solution follow from those of f(y), and these from one another, operation by operation (R. E. Moore,
"Interval Analysis", chapter 11; A. Jorba, M. Zou, Experimental Mathematics 14, 2005, which also has the step).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import isqrt, log2
from operator import mul
from typing import Any

from robodyn.errors import InputError
from robodyn.programs.program import Program
from robodyn.programs.run.multiprecision import context_of
from robodyn.programs.scalar import ADD, CONSTANT, COS, DIV, EXP, INPUT, MUL, NEG, SIGN, SIN, SQRT, SUB

BITS = 256
"""After the binary point; 77 decimal digits."""
Term = Callable[[int], None]
Series = list[int]


class Taylor:
    """The series of the solution through a state, to some order.

    Coefficient k of every operation is found from coefficients up to k of its operands.
    """

    def __init__(self, program: Program, source: str, width: int, order: int) -> None:
        """
        Args:
            program: its outputs are the rates of the first columns of its only source, which has `width` columns.

        Raises:
            InputError: mpmath is not installed; or the program has jumps, or other sources.
        """
        if any(name != source for name, _ in program.inputs) or SIGN in program.counts:
            raise InputError("equations with jumps, or that depend on time, have no power series")
        self.order, self.context = order, context_of(BITS * 3 // 10 + 20)
        self._state: list[Series] = [[] for _ in range(width)]
        self._series: list[Series] = []
        self._terms: list[Term] = []
        self._constants: dict[int, int] = {}
        self._lists: list[Series] = list(self._state)
        for op, a, b in program.operations:
            self._add(op, a, b)
        self._rates = [self._series[k] for k in program.outputs]

    def __call__(self, state: Sequence[int]) -> list[Series]:
        """For each number of the state its `order + 1` coefficients."""
        for each in self._lists:
            each.clear()
        for each, value in zip(self._state, state, strict=True):
            each.append(value)
        for k in range(self.order):
            for term in self._terms:
                term(k)
            for each, rate in zip(self._state, self._rates, strict=False):
                each.append(rate[k] // (k + 1))
            for each in self._state[len(self._rates) :]:
                each.append(0)
        return [list(each) for each in self._state]

    def _add(self, op: str, a: Any, b: Any) -> None:
        if op is INPUT:
            self._series.append(self._state[b])
            return
        out: Series = []
        self._lists.append(out)
        if op is CONSTANT:
            value = self._constants[len(self._series)] = fixed(a)
            self._terms.append(lambda k: out.append(0 if k else value))
        else:
            first = self._series[a]
            second = first if b is None else self._series[b]
            self._terms.append(self._term(op, first, second, out))
            if op is MUL and {a, b} & self._constants.keys():
                known = a if a in self._constants else b
                self._terms[-1] = _scaled(self._constants[known], second if known == a else first, out)
        self._series.append(out)

    def _term(self, op: str, a: Series, b: Series, out: Series) -> Term:
        if op in (SIN, COS, EXP):
            return self._transcendent(op, a, out)
        simple: dict[str, Term] = {
            ADD: lambda k: out.append(a[k] + b[k]),
            SUB: lambda k: out.append(a[k] - b[k]),
            NEG: lambda k: out.append(-a[k]),
            MUL: lambda k: out.append(sum(map(mul, a, reversed(b))) >> BITS),
            DIV: lambda k: out.append(((a[k] << BITS) - sum(map(mul, b[1:], reversed(out)))) // b[0]),
            SQRT: lambda k: out.append(
                ((a[k] << BITS) - sum(map(mul, out[1:], reversed(out[1:])))) // (2 * out[0])
                if k
                else isqrt(a[0] << BITS)
            ),
        }
        return simple[op]

    def _transcendent(self, op: str, a: Series, out: Series) -> Term:
        """By `e' = e a'`, `s' = c a'` and `c' = -s a'`."""
        slope: Series = []
        other: Series = out if op is EXP else []
        self._lists += [slope, other]
        sine, cosine = (out, other) if op is SIN else (other, out)

        def term(k: int) -> None:
            if not k:
                self._first(op, a[0], sine, cosine)
                return
            slope.append(k * a[k])
            if op is EXP:
                out.append((sum(map(mul, slope, reversed(out))) >> BITS) // k)
                return
            up, down = (sum(map(mul, slope, reversed(each))) >> BITS for each in (cosine, sine))
            sine.append(up // k)
            cosine.append(-down // k)

        return term

    def _first(self, op: str, angle: int, sine: Series, cosine: Series) -> None:
        number = self.context.ldexp(angle, -BITS)
        if op is EXP:
            cosine.append(self._fixed(self.context.exp(number)))
            return
        c, s = self.context.cos_sin(number)
        sine.append(self._fixed(s))
        cosine.append(self._fixed(c))

    def _fixed(self, number: Any) -> int:
        return int(self.context.ldexp(number, BITS))


def _scaled(factor: int, a: Series, out: Series) -> Term:
    return lambda k: out.append(factor * a[k] >> BITS)


def fixed(number: float) -> int:
    """Return the integer that stands for a float."""
    return int(Fraction(number) * (1 << BITS))


def step_of(series: Sequence[Series], tolerance: float) -> float:
    """Return the step at which the first term left out is about the tolerance [s]; infinite if the series end.

    By the radius of convergence that the later half of the coefficients shows, some of which may be zero.
    """
    order = len(series[0]) - 1
    inverse = 0.0
    for k in range(order // 2, order + 1):
        largest = max(abs(each[k]) for each in series)
        if largest:
            inverse = max(inverse, 2.0 ** ((log2(largest) - BITS) / k))
    return tolerance ** (1.0 / order) / inverse if inverse else float("inf")


def summed(series: Sequence[Series], step: int) -> list[int]:
    """Return the state after a step."""
    ends = []
    for each in series:
        total = 0
        for coefficient in reversed(each):
            total = (total * step >> BITS) + coefficient
        ends.append(total)
    return ends
