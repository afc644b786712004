"""First and second derivatives of sampled signals by one method: spline, Savitzky-Golay or central differences.

Where stamps are equally spaced every method is a filter: a matrix that takes as many samples as it sees to their
derivatives, whose middle row serves all samples but those near an end.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from robodyn.support.floats import Floats
from robodyn.support.sums import einsum
from robodyn.trajectory.derivatives.polynomials import at_samples, orthonormal

ORDER = 4
FEWEST = 7
"""Samples of a spline; through fewer goes one polynomial."""
REACH = 64
"""Samples over which a quintic spline forgets: its influence falls by 0.4306 a sample, to 4e-24 here."""


@dataclass(frozen=True)
class Method:
    """A way to differentiate.

    Args:
        kind: "spline" (interpolating quintic), "savgol" (least-squares polynomial over `window` samples), "central"
            (parabola through three samples) or "local" (`estimates.local_rates`, with windows up to `window`).
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
    def gains(self) -> Floats:
        """(2, w) standard deviation of both derivatives per standard deviation of white noise, of w samples a unit
        apart: first at an end, then in the middle."""
        width = self.window or 2 * REACH + 1
        gains: Floats = np.sqrt((_filter(self.kind == "spline", width, self.order) ** 2).sum(axis=2))
        return gains[:, : width // 2 + 1]


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
    6e-5 at the ends.
    """
    count, spacing = len(time), equal_spacing(time)
    spline = method.kind == "spline" and count >= FEWEST
    width = min(count, 2 * REACH + 1 if spline else method.window or FEWEST - 1)
    degree = min(method.order, width - 1)
    if spacing:
        first, second = _filtered(np.diff(values, axis=0), turns, _filter(spline, width, degree))
        return first / spacing, second / spacing / spacing
    if spline:
        return _spline(time, values, turns)
    return at_samples(time, values, turns, np.arange(count), width, degree)[1:]


def equal_spacing(time: Floats) -> float:
    """The spacing of stamps that are equally spaced to a few roundings, else 0."""
    if len(time) < 2:
        return 0.0
    spacing = float(time[-1] - time[0]) / (len(time) - 1)
    off = np.abs(time - (time[0] + spacing * np.arange(len(time)))).max()
    return spacing if off <= 4.0 * np.finfo(np.float64).eps * max(abs(time[0]), abs(time[-1])) else 0.0


@lru_cache(maxsize=64)
def _filter(spline: bool, width: int, degree: int) -> Floats:
    """(2, width, width) what takes samples a unit apart to their first and second derivatives."""
    if not spline:
        u = np.arange(width, dtype=np.float64) - (width - 1) / 2
        basis = orthonormal(u, u, degree)
        return np.stack([einsum("ki,kj->ij", each, basis.on) for each in (basis.slope, basis.curve)])
    knots = np.concatenate((np.zeros(6), np.arange(3.0, width - 3), np.full(6, width - 1.0)))  # not-a-knot
    at = np.arange(width, dtype=np.float64)[:, None]
    piece = np.minimum(np.searchsorted(knots, at[:, 0], "right"), width) - 1
    B = (np.arange(len(knots) - 1) == piece[:, None]).astype(np.float64)
    slope, curve = np.zeros_like(B), np.zeros_like(B)
    for k in range(1, 6):  # de Boor (1978), ch. X: values and derivatives of B-splines of degree k
        with np.errstate(all="ignore"):
            per = np.where(knots[k:] > knots[:-k], 1.0 / (knots[k:] - knots[:-k]), 0.0)
        left, right = (at - knots[: -k - 1]) * per[:-1], (knots[k + 1 :] - at) * per[1:]
        rise, fall = per[:-1], per[1:]
        curve = left * curve[:, :-1] + right * curve[:, 1:] + 2.0 * (rise * slope[:, :-1] - fall * slope[:, 1:])
        slope = left * slope[:, :-1] + right * slope[:, 1:] + rise * B[:, :-1] - fall * B[:, 1:]
        B = left * B[:, :-1] + right * B[:, 1:]
    inverse = np.linalg.inv(B)
    return np.stack((slope @ inverse, curve @ inverse))


def _filtered(steps: Floats, turns: Floats | None, operator: Floats) -> tuple[Floats, Floats]:
    """Both derivatives (N, c) of samples a unit apart, from the steps (N - 1, c) between them.

    In the middle steps as far before as after are taken together, so that a speed is exactly 0 where they cancel, on
    every processor.
    """
    if turns is not None:
        steps = steps - 2.0 * math.pi * np.diff(turns, axis=0)
    of_steps, width = -np.cumsum(operator, axis=2)[:, :, :-1], operator.shape[1]
    half, count = width // 2, len(steps) + 1
    inner = count - width + 1
    found, part = np.empty((2, steps.shape[1], count)), np.empty(inner)
    for k, column in enumerate(np.ascontiguousarray(steps.T)):
        found[:, k, :half] = einsum("dij,j->di", of_steps[:, :half], column[: width - 1])
        found[:, k, inner - 1 + half :] = einsum("dij,j->di", of_steps[:, half:], column[inner - 1 :])
        if inner > 1:
            middle = found[:, k, half : half + inner]
            middle[:] = 0.0
            for i in range(half):
                before, after = column[i : i + inner], column[width - 2 - i : width - 2 - i + inner]
                middle[0] += np.multiply(np.add(before, after, out=part), of_steps[0, half, i], out=part)
                middle[1] += np.multiply(np.subtract(before, after, out=part), of_steps[1, half, i], out=part)
    return found[0].T, found[1].T


def _spline(time: Floats, values: Floats, turns: Floats | None) -> tuple[Floats, Floats]:
    """Both derivatives of the interpolating quintic spline, not-a-knot at both ends: de Boor (1978), ch. XIII."""
    from scipy.interpolate import make_interp_spline

    steps, gaps = np.diff(values, axis=0), np.diff(time)[:, None]
    if turns is not None:
        steps -= 2.0 * math.pi * np.diff(turns, axis=0)
    mean = steps.sum(axis=0) / (time[-1] - time[0])  # without it nothing is lost where a joint turns for long
    moved = np.cumsum(np.pad(steps - mean * gaps, ((1, 0), (0, 0))), axis=0)
    try:
        curve = make_interp_spline(time, moved, k=5)
    except (ValueError, np.linalg.LinAlgError):  # stamps too uneven
        return np.full(values.shape, np.nan), np.full(values.shape, np.nan)
    return curve(time, 1) + mean, curve(time, 2)
