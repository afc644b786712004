"""The `multiprecision` executor: a program with as many digits as asked, for reference values."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import InputError
from robodyn.programs.program import Program
from robodyn.programs.scalar import ADD, COS, DIV, EXP, MUL, NEG, SIGN, SIN, SQRT, SUB
from robodyn.support.extras import need

DOUBLE_BITS = 1024
"""A double is less than 2 to this power."""


class Multiprecision:
    """A program made ready to run in mpmath's arithmetic; its `context` is its own, and `mpmath.mp` is left alone.

    What it does where a real number has no answer is what IEEE 754 does, and nothing raises: x / 0 is inf with the sign
    of x (a zero has no sign here), 0 / 0 and the square root of a negative number are nan, and nan and inf in the
    inputs go on as they do through doubles. A sum, product or quotient never overflows or underflows. The sine and
    cosine of a number of 2^1024 or more are nan and its exponential is inf or 0, as of a double that has overflowed.
    """

    def __init__(self, program: Program, *, digits: int = 50) -> None:
        """`digits`: decimal ones of every operation; InputError for less than 1, or where mpmath is not installed."""
        self.program, self.context = program, context_of(digits)
        context = self.context

        def within_doubles(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
            return lambda x: function(x if context.mag(x) <= DOUBLE_BITS else x * context.inf)

        self._functions: dict[str, Callable[..., Any]] = {
            ADD: operator.add,
            SUB: operator.sub,
            MUL: operator.mul,
            DIV: lambda a, b: a / b if b else a * context.inf,
            NEG: operator.neg,
            SQRT: lambda x: context.nan if x < 0 else context.sqrt(x),
            SIN: within_doubles(context.sin),
            COS: within_doubles(context.cos),
            SIGN: context.sign,
            EXP: within_doubles(context.exp),
        }

    def __call__(self, sources: Mapping[str, Any], samples: int) -> NDArray[np.object_]:
        """Return outputs (samples, outputs) of `mpmath.mpf` for arrays (samples, columns) of floats or mpmath numbers,
        each taken as the exact number that it is, however many digits that has.

        Accuracy: each operation is right to 10^(1 - digits) of its result. These are working digits: a program that
        cancels loses some of them. The digits that two runs with different `digits` share are those to be trusted.
        """
        convert, result = self.context.convert, np.empty((samples, len(self.program.outputs)), dtype=object)
        for row in range(samples):

            def column(source: str, index: int, row: int = row) -> Any:
                return convert(sources[source][row][index])

            result[row] = self.program.evaluated(column, convert, self._functions)
        return result


def context_of(digits: int) -> Any:
    need("digits beyond those of a double", "mpmath")
    import mpmath

    if digits < 1:
        raise InputError(f"{digits} digits hold no number", remedy="ask for 1 or more")
    context = mpmath.MPContext()
    context.dps = digits
    return context
