"""How noisy sampled signals are, by the grid they lie on and by differences; which method differentiates them best."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robodyn.support.floats import Floats, median
from robodyn.trajectory.derivatives.differentiate import (
    CENTRAL,
    DEGREE,
    REACH,
    SIZES,
    SPLINE,
    Method,
    at_samples,
    equal_spacing,
    savgol,
    windows,
)
from robodyn.trajectory.motion import NOISE

HIGHEST = 14  # highest difference looked at
_LEVEL = 0.7  # ratio of successive differences above which they no longer fall
_STILL = 32
FINEST_ENCODER = 2.0 * math.pi / 1024
_APART = 18
_COLOURED = 1.5  # power of a window's length: noise of steeper spectra is taken for motion
_UNSURE = 2.0
_MEDIAN = 0.6744897501960817
Run = tuple[Floats, Floats, Floats]  # a stretch of a table: time (N,), values as given and to differentiate (N, c)


@dataclass(frozen=True)
class Noise:
    """White noise found in a signal: standard deviation, grid, and why no noise is claimed where it might be."""

    sigma: float
    quantum: float
    warning: str = ""


def quantum(values: Floats) -> float:
    """The step of the grid on which all values (N,) lie (decimals, encoder counts), 0 if they lie on none: the greatest
    common divisor of gaps between distinct values, by Euclid's algorithm with a tolerance of 1 %."""
    levels = np.unique(values)
    if len(levels) < 2:
        return 0.0
    rounding = 16.0 * float(np.finfo(np.float64).eps) * float(np.abs(levels).max())
    gaps = np.diff(levels)
    step = float(gaps.min())
    while step > 64.0 * rounding:
        rest = np.abs(gaps - step * np.round(gaps / step))
        off = rest > np.maximum(0.01 * step, rounding)
        if not off.any():
            return float((levels[-1] - levels[0]) / np.round((levels[-1] - levels[0]) / step))
        step = float(rest[off].min())
    return 0.0


def _differences(time: Floats, values: Floats) -> Iterator[Floats]:
    """Divided differences (N - p,), p = 1..HIGHEST, scaled to keep the standard deviation of white noise."""
    even = bool(equal_spacing(time))
    weights = np.ones((len(time), 1))
    for p in range(1, HIGHEST + 1):
        gap = time[p:] - time[:-p]
        values = np.diff(values) / gap
        if even:
            yield values / (math.sqrt(math.comb(2 * p, p)) / math.factorial(p))
            continue
        weights = np.pad(weights[1:], ((0, 0), (1, 0))) - np.pad(weights[:-1], ((0, 0), (0, 1)))
        weights /= gap[:, None]
        yield values / np.sqrt((weights**2).sum(axis=1))


def estimate(runs: Sequence[Run]) -> Noise:
    """The noise in columns of a table, by `runs` of it: of several columns, that of the noisiest.

    Differences of a smooth signal fall with their order p, as (pi/n)^p for n samples a period; those of white noise,
    scaled by the norm of their weights, do not. So noise is what is left where the scaled divided differences stop
    falling (two neighbouring ratios above 0.7; a smooth signal with more than 4.5 samples a period stays below). The
    size is the median over the samples that are not at rest. On a grid no coarser than a 10-bit encoder the noise is at
    least the rms of the differences, up to the grid's own step / sqrt(12).

    No noise is claimed where it is a few roundings of the values themselves; where it is above both 0.01 rad (m) and
    1 % of the range (coarse samples, not noise); or where most samples repeat the one before and then jump (steps). The
    last two give a warning.

    Accuracy: within 20 % for white noise on a signal with 20 samples a period, from 1000 samples.
    """
    columns = runs[0][1].shape[1] if runs else 0
    found = [_of_column([(t, raw[:, i], values[:, i]) for t, raw, values in runs]) for i in range(columns)]
    return max(found, key=lambda noise: noise.sigma, default=Noise(0.0, 0.0))


def _of_column(runs: Sequence[Run]) -> Noise:
    raw = np.concatenate([values for _, values, _ in runs])
    grid = quantum(raw)
    scaled: list[list[Floats]] = [[] for _ in range(HIGHEST)]
    jumps: list[Floats] = []
    for time, _, values in runs:
        if len(time) <= 2 * HIGHEST:
            continue
        even = np.arange(len(time), dtype=np.float64)
        unit = even if equal_spacing(time) else (time - time[0]) / median(np.diff(time))
        changed = np.concatenate(([0], np.cumsum(np.diff(values) != 0.0)))
        row, last = np.arange(len(values)), len(values) - 1
        # within 32 samples: resting stretches say nothing about noise
        active = changed[np.minimum(row + _STILL, last)] > changed[np.maximum(row - _STILL, 0)]
        jumps.append(np.abs(np.diff(values))[active[1:]])
        for sizes, difference in zip(scaled, _differences(unit, values), strict=True):
            sizes.append(np.abs(difference[active[: len(difference)]]))
    sizes_of_order = [np.concatenate(parts) if parts else np.zeros(0) for parts in scaled]
    if not sizes_of_order[-1].size:
        return Noise(0.0, grid)
    fine = 0.0 < grid <= FINEST_ENCODER
    sigma = _floor([median(size) / _MEDIAN for size in sizes_of_order])
    if fine:
        spread = _floor([float(np.sqrt((size**2).mean())) for size in sizes_of_order])
        sigma = max(sigma, min(spread, grid / math.sqrt(12.0)))
    leaps = (changes := np.concatenate(jumps))[changes > 0.0]
    if 0 < 2 * len(leaps) < len(changes) and not (fine and median(leaps) <= 4.0 * grid):
        return Noise(0.0, grid, "most samples repeat the one before, then jump; steps are not smoothed")
    largest, span = float(np.abs(raw).max()), float(raw.max() - raw.min())
    if sigma <= 8.0 * float(np.finfo(np.float64).eps) * largest:
        return Noise(0.0, grid)
    if sigma > 0.01 and sigma > 0.01 * span:
        return Noise(0.0, grid, "sampled too coarsely to tell motion from noise; not smoothed")
    return Noise(sigma, grid)


def _floor(levels: list[float]) -> float:
    """Where levels of rising order stop falling, 0 if they do not."""
    for p in range(1, HIGHEST - 2):
        if levels[p + 1] > _LEVEL * levels[p] and levels[p + 2] > _LEVEL * levels[p + 1]:
            return min(levels[p:])
    return 0.0


def by_window(runs: Sequence[tuple[Floats, Floats]], sigma: float) -> tuple[float, ...]:
    """What white noise, sigma or more, would have to be to scatter fits on windows of each of `SIZES` as the data's
    does: by curvatures of parabolas on neighbouring windows that share no sample. The median counts as long as it grows
    with the length no faster than that of coloured noise; then the last value."""
    found: list[float] = []
    shorter, least, ended = 0.75 * SIZES[0][0], sigma, False
    for size in SIZES:
        length = size[0] * size[1]
        offs = [np.zeros(0)]
        for time, values in runs:
            if len(values) >= _APART * length:
                fits = windows(None if equal_spacing(time) else time, values, None, size, 0)
                of_unit = fits.basis.curve[2, 0] / fits.half**2
                curve, gain = fits.coefficients[2] * of_unit, of_unit + np.zeros_like(fits.coefficients[2])
                near, far = slice(None, -size[0]), slice(size[0], None)
                offs.append(np.abs(curve[far] - curve[near]) / np.sqrt(gain[near] ** 2 + gain[far] ** 2))
        off = np.concatenate(offs)
        if not ended and len(off):
            level = median(off[off > 0.0]) / _MEDIAN if (off > 0.0).any() else 0.0
            ended = level > max(least, sigma) * (length / shorter) ** _COLOURED
            if not ended:
                sigma = max(sigma, level * (1.0 - _UNSURE * math.sqrt(size[0] / len(off))))
                shorter, least = length, level
        found.append(sigma)
    return tuple(found)


WINDOWS = (7, 9, 13, 17, 23, 31, 41, 55, 75, 101, 135, 181, 241, 321, 431, 575, 767, 1023, 1365, 1819)
HARMLESS = 1e-3  # noise of the spline's derivative, relative to the derivative's rms, below which nothing is smoothed
NEAR = 3  # neighbours whose changes count in an error bar
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
        method: that the user chose if `forced`.
        noisy: whether noise does harm; smooth: whether one window serves all samples.
        sigma: standard deviation that bars are made of; scale: the same for windows of every length (`by_window`).
        level: rms of the highest derivative that is wanted, which is of this `order`; std: what noise leaves in it.
    """

    method: Method
    noisy: bool
    smooth: bool
    forced: bool
    noise: Noise
    sigma: float
    scale: tuple[float, ...]
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

    1. A signal without noise s (`estimate`) gets the quintic spline, and so does one whose noise is harmless: s times
       the spline's gain below 1e-3 of the rms of the derivative.
    2. A smooth motion gets quartic Savitzky-Golay with the window at which the derivative changes least, in the mean
       square, from one window of a geometric series to the next (quasi-optimality: Tikhonov and Glasko 1965). Below it
       the noise changes the derivative more, above it the error of smoothing does. The search ends where that change
       has risen to twice its least value, or the fit leaves more than twice the noise (discrepancy: Morozov 1966).
    3. A motion is smooth if that change then rises as fast as the error of smoothing does without corners; others get
       local polynomials with windows of their own for every sample (`derive`).

    Args:
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
    return Selection(method, noisy, smooth, mode != "auto", noise, sigma, scale, level, order, std)


def _scale(runs: Sequence[Run], sigma: float, noisy: bool, declared: float) -> tuple[float, ...]:
    """The noise for windows of every length worth trying: of the noisiest column, and of rounding."""
    largest = max((float(np.abs(raw).max()) for _, raw, _ in runs), default=0.0)
    sigma = max(sigma, _ROUNDINGS * float(np.finfo(np.float64).eps) * largest, float(np.finfo(np.float64).tiny))
    longest = max((len(time) for time, _, _ in runs), default=0)
    count = sum(parts * part <= longest for parts, part in SIZES) or 1
    if not noisy:
        return (sigma,) * min(_SHORT, count)
    few = max(1, _ROWS // longest)  # the first, the last and some runs between, of few rows in all
    some = [runs[k] for k in np.unique(np.linspace(0, len(runs) - 1, min(few, len(runs))).astype(int))]
    each = [by_window([(t, x[:, k]) for t, _, x in some], sigma) for k in range(some[0][2].shape[1])]
    # the white noise whose bar is what an oscillation of this amplitude does to a fit at the worst
    cyclic = [declared * math.sqrt(0.5 * parts * part) / NOISE for parts, part in SIZES]
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
