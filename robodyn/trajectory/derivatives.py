"""First and second derivatives of sampled signals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from robodyn.support.floats import Floats
from robodyn.trajectory.local_polynomials import at_samples, equally_spaced, stencil
from robodyn.trajectory.quintic import FEWEST, REACH, spline_rates

ORDER = 4


@dataclass(frozen=True)
class Method:
    """A way to differentiate.

    Args:
        kind: "spline" (interpolating quintic), "savgol" (least-squares polynomial over `window` samples), "central"
            (parabola through three samples) or "local" (`adaptive.rates`, with windows up to `window`).
        window: number of samples; 0 for the spline, which sees them all.
        order: of the polynomial.
    """

    kind: Literal["spline", "savgol", "central", "local"]
    window: int = 0
    order: int = 5

    @property
    def text(self) -> str:
        """The method as the report names it."""
        if self.kind == "savgol":
            return f"Savitzky-Golay (window {self.window}, order {self.order})"
        if self.kind == "local":
            return f"local polynomials (windows up to {self.window})"
        return "quintic spline" if self.kind == "spline" else "central differences"

    @property
    def halo(self) -> int:
        """Neighbours on either side of a block that make its derivatives those of the whole table."""
        return REACH if self.kind == "spline" else 2 * self.window

    @property
    def gains(self) -> Gains:
        """What the method makes of noise."""
        return _gains(self)


@dataclass(frozen=True)
class Gains:
    """Standard deviation of the derivatives per standard deviation of white noise, for samples a unit apart.

    Attributes:
        first, second: in the middle of a table.
        first_ends, second_ends: at the samples from an end to just before the middle of a window.
    """

    first: float
    second: float
    first_ends: Floats
    second_ends: Floats


@lru_cache(maxsize=64)
def _gains(method: Method) -> Gains:
    if method.kind == "spline":
        operators = spline_rates(None, np.diff(np.eye(2 * REACH + 1), axis=0))
        first, second = (np.sqrt((each * each).sum(axis=1)) for each in operators)
    else:
        basis = stencil(method.window, method.order)
        first, second = (np.sqrt((each * each).sum(axis=0)) for each in (basis.slope, basis.curve))
    half = len(first) // 2
    return Gains(float(first[half]), float(second[half]), first[:half], second[:half])


SPLINE = Method("spline")
CENTRAL = Method("central", 3, 2)


def savgol(window: int) -> Method:
    """Savitzky-Golay with quartic polynomials."""
    return Method("savgol", window, ORDER)


def differentiate(time: Floats, values: Floats, method: Method, turns: Floats | None = None) -> tuple[Floats, Floats]:
    """(d/dt, d^2/dt^2) of values at their own times.

    Equal spacing (to rounding) counts as exactly equal; otherwise the spline and the local polynomials take the stamps
    as they are (no resampling). Fewer samples than the method wants: the polynomial through, or fitted to, them all.

    Args:
        time: (N,) s, increasing, N >= 2 (N >= 3 for a second derivative that is not 0).
        values: (N, c); turns: (N, c) whole turns of 2 pi that they are ahead by, None for none. Only what they change
            by matters, so nothing is lost far from zero.

    Returns:
        Two arrays (N, c); NaN where stamps are so uneven that nothing can be told.

    Accuracy: the spline's second derivative of sin(2 pi t) at 10 ms: 9e-7 (h^4 / 720 times the sixth derivative), and
    6e-5 at the ends. All sums are taken in a fixed order: results are the same to the bit on every processor.
    """
    count, spacing = len(time), equal_spacing(time)
    width = min(count, method.window or FEWEST - 1)
    degree = min(method.order, width - 1)
    spline = method.kind == "spline" and count >= FEWEST
    if not spline and not (spacing and width == method.window):
        return at_samples(time, values, turns, np.arange(count), width, degree)[1:]
    steps = np.diff(values, axis=0)
    if turns is not None:
        steps -= 2.0 * math.pi * np.diff(turns, axis=0)
    if not spacing:
        return spline_rates(np.diff(time), steps)
    first, second = spline_rates(None, steps) if spline else equally_spaced(steps, width, degree)
    return first / spacing, second / spacing / spacing


def equal_spacing(time: Floats) -> float:
    """The spacing of stamps that are equally spaced to a few roundings, else 0."""
    if len(time) < 2:
        return 0.0
    spacing = float(time[-1] - time[0]) / (len(time) - 1)
    off = np.abs(time - (time[0] + spacing * np.arange(len(time)))).max()
    return spacing if off <= 4.0 * np.finfo(np.float64).eps * max(abs(time[0]), abs(time[-1])) else 0.0
