"""Derivatives of sampled columns with their error bars: which method each deserves, and how far it can be trusted."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from robodyn.support.floats import Floats
from robodyn.trajectory import adaptive
from robodyn.trajectory.adaptive import Rate
from robodyn.trajectory.derivatives import SPLINE, Method, differentiate, equal_spacing
from robodyn.trajectory.motion import NOISE
from robodyn.trajectory.quintic import REACH
from robodyn.trajectory.windows import SIZES

INNER, END, WIDER = 3.0, 8.0, 3.0
"""Bars of one window for all samples: standard deviations of the noise, in the middle and near an end, and how often
counts what a wider window changes."""
CORNER = 1e-3
"""Of the rms of a derivative: where the spline may be off by more, there may be a corner."""
NEAR, FEWEST = 3, 6
"""Neighbours whose changes count, and samples of which half are enough for a second derivative."""
NOISY = 128
"""Rows of a table below which what looks like noise may as well be the motion."""


@dataclass(frozen=True)
class Trust:
    """What is known of a group of columns before they are differentiated.

    Attributes:
        noisy: whether noise does harm; smooth: whether one window serves all samples; forced: whether the user chose
            the method.
        sigma: standard deviation of the noise; scale: the same for windows of every length (`noise.by_window`).
        window: samples of the one window that suits the table best.
        level: rms of the highest derivative that is wanted, which is of this `order`.
    """

    noisy: bool
    smooth: bool
    forced: bool
    sigma: float
    scale: tuple[float, ...]
    window: int
    level: float
    order: int


def reach(trust: Trust) -> int:
    """Return how many neighbours on either side the derivatives of a sample depend on."""
    return max(2 * REACH, *(parts * part for parts, part in SIZES[: len(trust.scale)])) + NEAR


def estimated(
    time: Floats, values: Floats, turns: Floats | None, method: Method, trust: Trust, first: int = 0
) -> tuple[Rate, Rate]:
    """Return the first and second derivatives (N, c) of values (N, c), with error bars.

    Args: as of `differentiate`; first: of the samples, counted in the table.

    Accuracy: bars cover 19 of 20 errors of peaks, for motions of all kinds (`accuracy/test_bars_of_motions.py`).
    """
    if method.kind == "savgol" and trust.smooth and not trust.forced:
        return _by_one_window(time, values, turns, method, trust.sigma)
    best = _best(time, values, turns, trust, first)
    if not trust.forced:
        return best
    slopes, curves = (
        Rate(value, noise + 0.0 * value, np.abs(value - each.value) + each.off)
        for value, noise, each in zip(
            differentiate(time, values, method, turns), _noises(time, method, trust.sigma), best, strict=True
        )
    )
    return slopes, curves


def _noises(time: Floats, method: Method, sigma: float) -> tuple[Floats, Floats]:
    """Return (N, 1) the standard deviations that noise gives both derivatives."""
    spacing, count, gains = np.float64((time[-1] - time[0]) / max(1, len(time) - 1)), len(time), method.gains
    found = []
    for order, inner, ends in ((1, gains.first, gains.first_ends), (2, gains.second, gains.second_ends)):
        noise, near = np.full(count, inner), ends[: count // 2]
        noise[: len(near)], noise[count - len(near) :] = near, near[::-1]
        found.append((noise * sigma / spacing**order)[:, None])
    return found[0], found[1]


def _by_one_window(
    time: Floats, values: Floats, turns: Floats | None, method: Method, sigma: float
) -> tuple[Rate, Rate]:
    """Return what one window gives, with what the noise leaves, and what a window a third wider changes nearby.

    The window is as wide as makes what it smooths away no larger than the noise that it leaves; near an end a
    polynomial smooths less well.
    """
    wider, ends, near = method.window * 4 // 3 | 1, min(method.window // 2, len(time) // 2), method.window // 4
    times = np.full((len(time), 1), INNER)
    times[:ends] = times[len(time) - ends :] = END
    own = differentiate(time, values, method, turns)
    others = differentiate(time, values, replace(method, window=wider), turns)
    rates = []
    for value, other, noise in zip(own, others, _noises(time, method, sigma), strict=True):
        padded = np.pad(np.abs(other - value), ((near, near), (0, 0)))
        change = sliding_window_view(padded, 2 * near + 1, axis=0).max(axis=-1)
        rates.append(Rate(value, noise + 0.0 * value, times * noise + WIDER * change))
    return rates[0], rates[1]


def _best(time: Floats, values: Floats, turns: Floats | None, trust: Trust, first: int) -> tuple[Rate, Rate]:
    """Return the quintic spline where it can be trusted, and what local polynomials make of it elsewhere."""
    spline = _spline(time, values, turns, trust.sigma)
    changes = [rate.off - NOISE * rate.noise for rate in spline]
    wanted = np.full(values.shape, True) if trust.noisy else changes[trust.order - 1] > CORNER * trust.level
    spacing, order = equal_spacing(time), trust.order
    unit = spacing or 1.0
    for k in np.flatnonzero(wanted.any(axis=0)):
        rows, turned = wanted[:, k], None if turns is None else turns[:, k]
        parts = spline[0].value[:, k], *(part[:, k] for part in spline[order - 1])
        slope, *rate = (part * unit**each for part, each in zip(parts, (1, *[order] * 3), strict=True))
        own, found = adaptive.rates(
            *(None if spacing else time, values[:, k], turned, trust.scale, order),
            *((slope, Rate(*rate)), first, trust.noisy),
        )
        for whole, part, each in zip(parts, (own, *found), (1, *[order] * 3), strict=True):
            whole[rows] = part[rows] / unit**each
    if len(time) < NOISY:
        for found, least in zip(spline, changes, strict=True):
            np.maximum(found.off, least, out=found.off)
    return spline


def _spline(time: Floats, values: Floats, turns: Floats | None, sigma: float) -> tuple[Rate, Rate]:
    """Return the quintic spline, with twice the largest change nearby that leaving out every second sample makes.

    That is 32 times the error of a smooth motion, and about the error at corners of the velocity.
    """
    whole = differentiate(time, values, SPLINE, turns)
    changes = [np.zeros((len(time) + 2 * NEAR, values.shape[1])) for _ in whole]
    for first in (0, 1) if len(time) >= FEWEST else ():
        rows = slice(first, None, 2)
        coarse = differentiate(time[rows], values[rows], SPLINE, None if turns is None else turns[rows])
        for change, half, full in zip(changes, coarse, whole, strict=True):
            off = np.abs(half - full[rows])
            change[NEAR:-NEAR][rows] = np.where(np.isfinite(off), off, np.abs(full[rows]))
    rates = []
    for full, change, noise in zip(whole, changes, _noises(time, SPLINE, sigma), strict=True):
        largest = sliding_window_view(change, 2 * NEAR + 1, axis=0).max(axis=-1)
        rates.append(Rate(full.copy(), noise + np.zeros_like(full), NOISE * noise + 2.0 * largest))
    return rates[0], rates[1]
