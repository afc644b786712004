"""Which method differentiates a signal best, and how far it can be trusted, judged by the noise in it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robodyn.support.floats import Floats, median
from robodyn.trajectory.derivatives.differentiate import CENTRAL, REACH, SPLINE, Method, equal_spacing, savgol
from robodyn.trajectory.derivatives.noise import Noise, by_window, estimate
from robodyn.trajectory.derivatives.polynomials import DEGREE, SIZES, at_samples, coherent

Run = tuple[Floats, Floats, Floats]
WINDOWS = (7, 9, 13, 17, 23, 31, 41, 55, 75, 101, 135, 181, 241, 321, 431, 575, 767, 1023, 1365, 1819)
HARMLESS = 1e-3
"""Noise of the spline's derivative, relative to the derivative's rms, below which nothing is smoothed."""
NEAR = 3
"""Neighbours whose changes count in an error bar."""
_CENTRES = 1024
_TURNED = 4.0
_RESIDUAL = 2.0
_LATER, _FEWEST, _STEEP = 4, 2, 60.0
"""Four windows wider the squared error of smoothing is 10 times as large where the rate of the acceleration jumps, and
thousands of times where nothing does; the least change is half noise."""
_ROWS = 1 << 14
_SHORT = 8
_ROUNDINGS = 4.0


@dataclass(frozen=True)
class Selection:
    """The method for a group of columns, and what is known of them before they are differentiated.

    Attributes:
        method: that differentiates them, or that the user chose if `forced`.
        noisy: whether noise does harm; smooth: whether one window serves all samples.
        noise: found in the columns; sigma: standard deviation that bars are made of; scale: the same for windows of
            every length (`noise.by_window`).
        window: samples of the one window that suits the table best.
        level: rms of the highest derivative that is wanted, which is of this `order`; std: what noise leaves in it.
    """

    method: Method
    noisy: bool
    smooth: bool
    forced: bool
    noise: Noise
    sigma: float
    scale: tuple[float, ...]
    window: int
    level: float
    order: int
    std: float

    @property
    def halo(self) -> int:
        """Neighbours on either side that the derivatives of a sample and their bars depend on."""
        local = max(2 * REACH, *(parts * part for parts, part in SIZES[: len(self.scale)])) + NEAR
        return max(self.method.halo, local)


def select(runs: Sequence[Run], order: int, mode: str, declared: float = 0.0) -> Selection:
    """The method that differentiates these columns best.

    1. The noise s is estimated by `noise.estimate`; a signal without noise, or one that moves in steps or is too coarse
       to tell, gets the quintic spline.
    2. So does a signal whose noise is harmless: s times the spline's gain below 1e-3 of the rms of the derivative.
    3. A smooth motion gets quartic Savitzky-Golay with the window at which the derivative changes least, in the mean
       square, from one window of a geometric series to the next (quasi-optimality: Tikhonov and Glasko 1965). Below it
       the noise changes the derivative more, above it the error of smoothing does. The search ends where that change
       has risen to twice its least value, or the fit leaves more than twice the noise (discrepancy: Morozov 1966).
    4. A motion is smooth if that change then rises as fast as the error of smoothing does without corners; others get
       local polynomials with windows of their own for every sample (`estimates.local_rates`).

    Args:
        runs: (time (N,), values as given (N, c), values to differentiate (N, c)) of stretches of the table.
        order: the highest derivative wanted, 1 or 2.
        mode: "auto", or the method to use: "spline", "savgol" (the window as above), "central".
        declared: amplitude of a cyclic error, which no window averages where it moves with the motion.
    """
    runs = [run for run in runs if len(run[0]) > 1]
    noise = estimate(runs)
    if declared:
        noise = replace(noise, sigma=max(noise.sigma, declared / math.sqrt(2.0)))
    spacing = np.float64(median(np.concatenate([np.diff(time) for time, _, _ in runs])) if runs else 1.0)
    window, smooth, level, harmless = _search(runs, order, noise, spacing)
    noisy = noise.sigma > 0.0 and (not harmless or declared > 0.0)
    scale, sigma = _scale(runs, noise.sigma, noisy, declared), noise.sigma
    smooth = noisy and smooth and not declared
    if smooth:
        scale = scale[: max(1, sum(parts * part <= window for parts, part in SIZES))]
    if mode == "central":
        method = CENTRAL
    elif mode == "spline" or not (noisy or mode == "savgol"):
        method = SPLINE
    elif smooth or mode == "savgol":
        method = savgol(window)
        sigma = max(sigma, scale[-1]) if smooth else sigma
    else:
        method = Method("local", max(parts * part for parts, part in SIZES[: len(scale)]), DEGREE)
    gains = (savgol(window) if method.kind == "local" else method).gains
    std = float(sigma * gains[order - 1, -1] / spacing**order)
    return Selection(method, noisy, smooth, mode != "auto", noise, sigma, scale, window, level, order, std)


def _scale(runs: Sequence[Run], sigma: float, noisy: bool, declared: float) -> tuple[float, ...]:
    """The noise for windows of every length that is worth trying: of the noisiest column, and of rounding."""
    largest = max((float(np.abs(raw).max()) for _, raw, _ in runs), default=0.0)
    sigma = max(sigma, _ROUNDINGS * float(np.finfo(np.float64).eps) * largest, float(np.finfo(np.float64).tiny))
    longest = max((len(time) for time, _, _ in runs), default=0)
    count = sum(parts * part <= longest for parts, part in SIZES) or 1
    if not noisy:
        return (sigma,) * min(_SHORT, count)
    few = max(1, _ROWS // longest)  # the first, the last and some runs between, of few rows in all
    some = [runs[k] for k in np.unique(np.linspace(0, len(runs) - 1, min(few, len(runs))).astype(int))]
    each = [by_window([(t, x[:, k]) for t, _, x in some], sigma) for k in range(some[0][2].shape[1])]
    cyclic = [coherent(declared, parts * part) for parts, part in SIZES]
    return tuple(max(column) for column in zip(*each, cyclic, strict=True))[:count]


def _search(runs: Sequence[Run], order: int, noise: Noise, spacing: np.float64) -> tuple[int, bool, float, bool]:
    """The window of a table, whether one serves all samples, the derivative's rms, and whether noise is harmless."""
    runs = [run for run in runs if len(run[0]) >= 2 * WINDOWS[0]]
    if not runs:
        return WINDOWS[0], False, 0.0, True
    widest = min(len(time) for time, _, _ in runs) // 2
    methods = [savgol(window) for window in WINDOWS if window <= widest]
    allowed = np.float64(_RESIDUAL * max(noise.sigma, noise.quantum / math.sqrt(12.0))) ** 2
    chosen, least, risen, ended = 0, math.inf, 0, False
    after: list[float] = []
    derivative, _ = _sampled(runs, methods[0], order)
    now = derivative
    for k, wider in enumerate(methods[1:], start=1):
        last, (now, residual) = now, _sampled(runs, wider, order)
        change = float(((now - last) ** 2).mean())
        risen = risen + 1 if change > _TURNED * least else 0
        after.append(change)
        ended = ended or risen == 2 or bool((residual**2).mean() > allowed)
        if ended and k >= chosen + _LATER:
            break
        if change < least and not ended:
            chosen, least, derivative, after = k, change, now, []
    noise_of_spline = np.float64(noise.sigma) * SPLINE.gains[order - 1, -1] / spacing**order
    square = float((derivative**2).mean())
    steep = [change > _STEEP ** (min(k, _LATER) / _LATER) * least for k, change in enumerate(after, start=1)]
    smooth = any(steep[_LATER - 1 :]) if len(after) >= _LATER else len(after) >= _FEWEST and steep[-1]
    harmless = bool(noise_of_spline**2 <= HARMLESS**2 * square)
    return methods[chosen].window, smooth, math.sqrt(square), harmless


def _sampled(runs: Sequence[Run], method: Method, order: int) -> tuple[Floats, Floats]:
    """Derivative and residual (k, c) at samples spread over the runs, the same samples for every method."""
    count = max(1, _CENTRES // len(runs))
    derivatives, residuals = [], []
    for time, _, values in runs:
        centres = np.unique(np.linspace(0, len(time) - 1, count + 2).astype(np.intp)[1:-1])
        spacing = equal_spacing(time)
        stamps = None if spacing else time
        residual, *rates = at_samples(stamps, values, None, centres, method.window, method.order)
        residuals.append(residual)
        derivatives.append(rates[order - 1] / np.float64(spacing or 1.0) ** order)
    return np.concatenate(derivatives), np.concatenate(residuals)
