"""Programs as sums of sines and cosines: the closed form that every entry of the equations of motion has."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

from robodyn.equations.polynomial import Budget, Key, Polynomial, constant, generator, linear, product, total, wave
from robodyn.programs.program import Program
from robodyn.programs.run.symbolic import DIGITS, module, number, operations
from robodyn.programs.scalar import ADD, CONSTANT, COS, DIV, INPUT, MUL, NEG, SIN

SHORT = 16 * 2.0**-52
"""A coefficient this near a short decimal, as a share of itself, is taken to be that decimal."""


class Forms:
    """Programs in the arithmetic of `robodyn.equations.polynomial`.

    What is no such polynomial (the sign of a speed, a root) becomes a generator of its own, with its argument in
    closed form.
    """

    def __init__(self, symbols: Mapping[tuple[str, int], Any], products: int) -> None:
        """
        Args:
            symbols: SymPy symbols of the inputs; rates stand apart in results, being of the sources qd and qdd.
            products: of terms that may be formed; `TooLargeError` is raised beyond.
        """
        self._symbols, self._budget = symbols, Budget(products)
        self._generators: dict[Any, int] = {symbol: k for k, symbol in enumerate(symbols.values())}
        self._rates = {symbol for (source, _), symbol in symbols.items() if source != "q"}

    def outputs(self, program: Program) -> list[Polynomial]:
        """Return the outputs of a program.

        Raises:
            TooLargeError: the budget is spent.
        """
        values: list[Polynomial] = []
        for op, a, b in program.operations:
            if op is INPUT:
                values.append(self._generator(self._symbols[a, b]))
            elif op is CONSTANT:
                values.append(constant(a))
            else:
                values.append(self._operation(op, *(values[k] for k in (a, b) if k is not None)))
        return [values[k] for k in program.outputs]

    def expression(self, form: Polynomial, least: float = 0.0) -> Any:
        """Return the SymPy expression of a form, sorted by products of rates.

        Args:
            least: smaller coefficients are left out.
        """
        sympy, symbols = module(), list(self._generators)
        groups: defaultdict[Any, list[Any]] = defaultdict(list)
        for key, coefficient in form.items():
            if abs(coefficient.value) < least:
                continue
            powers = [symbols[k] for k in key.powers]
            rates = sympy.Mul(*(x for x in powers if x in self._rates))
            rest = sympy.Mul(*(x for x in powers if x not in self._rates))
            groups[rates].append(_rounded(coefficient.value) * rest * self._wave(key))
        return sympy.Add(*(rates * sympy.Add(*terms) for rates, terms in groups.items()))

    def _wave(self, key: Key) -> Any:
        if not key.angle:
            return 1
        sympy, symbols = module(), list(self._generators)
        angle = sympy.Add(*(number(x) * symbols[k] for k, x in enumerate(key.angle)))
        return getattr(sympy, key.wave)(angle)

    def _operation(self, op: str, a: Polynomial, b: Polynomial | None = None) -> Polynomial:
        if b is None:
            return self._function(op, a)
        if op is MUL:
            return product(a, b, self._budget)
        return self._quotient(a, b) if op is DIV else total(a, b, 1.0 if op is ADD else -1.0)

    def _function(self, op: str, a: Polynomial) -> Polynomial:
        if op is NEG:
            return total({}, a, -1.0)
        return self._turned(op, a) if op in (SIN, COS) else self._opaque(operations()[op](self.expression(a)))

    def _quotient(self, a: Polynomial, b: Polynomial) -> Polynomial:
        angle, divisor = linear(b) or ((1.0,), 0.0)
        inverse = self._opaque(1 / self.expression(b)) if angle else constant(1.0 / divisor)
        return product(a, inverse, self._budget)

    def _turned(self, op: str, a: Polynomial) -> Polynomial:
        """Return the sine or cosine of a; a constant in the angle turns one into the other."""
        known = linear(a)
        if known is None:
            return self._opaque(operations()[op](self.expression(a)))
        angle, offset = known
        sine, cosine = wave("sin", angle), wave("cos", angle)
        first, second = (cosine, sine) if op is COS else (sine, cosine)
        turned = product(second, constant(math.sin(offset)), self._budget)
        return total(product(first, constant(math.cos(offset)), self._budget), turned, -1.0 if op is COS else 1.0)

    def _opaque(self, expression: Any) -> Polynomial:
        if expression.is_number:
            return constant(float(expression))
        return self._generator(expression)

    def _generator(self, expression: Any) -> Polynomial:
        return generator(self._generators.setdefault(expression, len(self._generators)))


def largest(forms: Sequence[Polynomial]) -> float:
    """Return the largest coefficient."""
    return max((abs(x.value) for form in forms for x in form.values()), default=0.0)


def _rounded(value: float) -> Any:
    """Return the short decimal next to a coefficient, if rounding alone can tell them apart."""
    short = float(f"{value:.{DIGITS - 1}e}")
    return number(short if abs(short - value) <= SHORT * abs(value) else value)
