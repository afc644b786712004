"""A figure with its error bar: of its first term where that holds, else of draws."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from robodyn.loads.uncertainty_result import Bar, Interval
from robodyn.support.floats import BEYOND, Floats

NEAR = 1.959963984540054
"""Standard errors on either side that hold 95 % of a normal figure."""


class Drawn(NamedTuple):
    """A figure.

    Attributes:
        value: with its sign; error: its standard error to first order; gradient: (m,) of its magnitude by theta.
        parts: (k,) what each parameter adds to its variance, in some unit.
        curved: (draws,) of its magnitude, where the gradient alone would mislead; else None.
    """

    value: float
    error: float
    gradient: Floats
    parts: Floats
    curved: Floats | None = None

    def bar(self, sampled: Floats | None = None) -> Bar:
        """Return the error bar; sampled: magnitudes of motions that were run again."""
        sign = -1.0 if self.value < 0.0 else 1.0
        other = None if sampled is None else _interval(sampled, sign)
        if self.curved is None:
            reach = NEAR * self.error
            return Bar(self.value, self.error, self.value - reach, self.value + reach, "linear", other)
        found = _interval(self.curved, sign)
        return Bar(self.value, found.standard_error, found.low, found.high, "draws", other)

    def within(self, limit: float) -> float:
        """Return the probability that the magnitude is within a limit."""
        if self.curved is not None:
            return float((self.curved <= BEYOND * limit).mean())
        if self.error <= 1e-12 * max(abs(self.value), abs(limit)):
            return float(abs(self.value) <= BEYOND * limit)
        return normal((limit - abs(self.value)) / self.error)


def _interval(draws: Floats, sign: float) -> Interval:
    """Return standard error and interval of a figure whose magnitudes were drawn."""
    low, high = np.quantile(sign * draws, (0.025, 0.975)).tolist()
    return Interval(float(draws.std(ddof=1)) if len(draws) > 1 else 0.0, low, high)


def normal(u: float) -> float:
    """Return the probability that a standard normal number is below u."""
    return 0.5 * math.erfc(-u / math.sqrt(2.0))
