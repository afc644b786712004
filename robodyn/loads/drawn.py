"""A figure with its error bar: of its first term where that holds, else of draws."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from robodyn.loads.uncertainty_result import Bar
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

    def bar(self) -> Bar:
        """Return the error bar."""
        sign = -1.0 if self.value < 0.0 else 1.0
        if self.curved is None:
            reach = NEAR * self.error
            return Bar(self.value, self.error, self.value - reach, self.value + reach, "linear")
        low, high = np.quantile(sign * self.curved, (0.025, 0.975)).tolist()
        return Bar(self.value, float(self.curved.std(ddof=1)), low, high, "draws")

    def within(self, limit: float) -> float:
        """Return the probability that the magnitude is within a limit."""
        if self.curved is not None:
            return float((self.curved <= BEYOND * limit).mean())
        if self.error <= 1e-12 * max(abs(self.value), abs(limit)):
            return float(abs(self.value) <= BEYOND * limit)
        return normal((limit - abs(self.value)) / self.error)


def normal(u: float) -> float:
    """Return the probability that a standard normal number is below u."""
    return 0.5 * math.erfc(-u / math.sqrt(2.0))
