"""How noisy sampled signals are: the grid they lie on, and the noise that differences reveal."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robodyn.support.floats import Floats, median
from robodyn.trajectory.derivatives.differentiate import equal_spacing
from robodyn.trajectory.derivatives.polynomials import SIZES, windows

HIGHEST = 14
"""Highest difference looked at."""
_LEVEL = 0.7
"""Ratio of successive differences above which they no longer fall: white noise has 1, n samples a period sin(pi/n)"""
_STILL = 32
FINEST_ENCODER = 2.0 * math.pi / 1024
_APART = 18
_COLOURED = 1.5
"""Power of a window's length: noise of steeper spectra is taken for motion"""
_UNSURE = 2.0
_MEDIAN = 0.6744897501960817


@dataclass(frozen=True)
class Noise:
    """White noise found in a signal: standard deviation, grid, and why no noise is claimed where it might be."""

    sigma: float
    quantum: float
    warning: str = ""


def quantum(values: Floats) -> float:
    """The step of the grid on which all values (N,) lie (decimals, encoder counts), 0 if they lie on none.

    The greatest common divisor of the gaps between distinct values, by Euclid's algorithm with a tolerance of 1 %.
    """
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
    """For p = 1..HIGHEST the divided differences (N - p,), scaled to keep the standard deviation of white noise.

    Args:
        time: (N,) stamps about a unit apart.
    """
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


def _moving(values: Floats) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Whether each sample has a change within 32 samples; resting stretches say nothing about noise."""
    changes = np.concatenate(([0], np.cumsum(np.diff(values) != 0.0)))
    index = np.arange(len(values))
    after, before = np.minimum(index + _STILL, len(changes) - 1), np.maximum(index - _STILL, 0)
    return np.asarray(changes[after] > changes[before])


def estimate(runs: Sequence[tuple[Floats, Floats, Floats]]) -> Noise:
    """The noise in columns of a table: of several columns, that of the noisiest.

    Differences of a smooth signal fall with their order p, as (pi/n)^p for n samples a period; those of white noise,
    scaled by the norm of their weights, do not. So noise is what is left where the scaled divided differences stop
    falling (two neighbouring ratios above 0.7; a smooth signal with more than 4.5 samples a period stays below). The
    size is the median over the samples, so that single corners and steps do not count; stretches at rest are left out.
    On a grid no coarser than a 10-bit encoder the noise is at least the rms of the differences, up to the grid's own
    step / sqrt(12).

    No noise is claimed where it is a few roundings of the values themselves; where it is above both 0.01 rad (m) and
    1 % of the range (coarse samples, not noise); or where most samples repeat the one before and then jump (steps). The
    last two give a warning.

    Args:
        runs: (time (N,), values as given (N, c), values to differentiate (N, c)) of stretches of the table.

    Accuracy: within 20 % for white noise on a signal with 20 samples a period, from 1000 samples.
    """
    columns = runs[0][1].shape[1] if runs else 0
    found = [_of_column([(t, raw[:, i], values[:, i]) for t, raw, values in runs]) for i in range(columns)]
    return max(found, key=lambda noise: noise.sigma, default=Noise(0.0, 0.0))


def _of_column(runs: Sequence[tuple[Floats, Floats, Floats]]) -> Noise:
    raw = np.concatenate([values for _, values, _ in runs])
    grid = quantum(raw)
    scaled: list[list[Floats]] = [[] for _ in range(HIGHEST)]
    jumps = []
    for time, _, values in runs:
        if len(time) <= 2 * HIGHEST:
            continue
        even = np.arange(len(time), dtype=np.float64)
        unit = even if equal_spacing(time) else (time - time[0]) / median(np.diff(time))
        active = _moving(values)
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
    """What white noise would have to be to scatter the fits on windows of each of `SIZES` as the data's does.

    Of neighbouring windows that share no sample the curvatures of parabolas differ by noise, and by what the motion
    does; the median over a table is the noise's as long as it grows no faster with the length than that of coloured
    noise. From where it does the last value counts.

    Args:
        runs: (time (N,), values (N,)) of stretches of the table; sigma: the least that is returned.
    """
    found: list[float] = []
    shorter, least, ended = 0.75 * SIZES[0][0], sigma, False
    for size in SIZES:
        length = size[0] * size[1]
        off = np.concatenate([_scatter(time, values, size) for time, values in runs])
        if not ended and len(off):
            level = median(off[off > 0.0]) / _MEDIAN if (off > 0.0).any() else 0.0
            ended = level > max(least, sigma) * (length / shorter) ** _COLOURED
            if not ended:
                sigma = max(sigma, level * (1.0 - _UNSURE * math.sqrt(size[0] / len(off))))
                shorter, least = length, level
        found.append(sigma)
    return tuple(found)


def _scatter(time: Floats, values: Floats, size: tuple[int, int]) -> Floats:
    """Differences of parabolas' curvatures on windows side by side, as deviations of white noise."""
    if len(values) < _APART * size[0] * size[1]:
        return np.zeros(0)
    fits = windows(None if equal_spacing(time) else time, values, None, size, 0)
    curve = fits.coefficients[2] * fits.basis.curve[2, 0] / fits.half**2
    gain = fits.basis.curve[2, 0] / fits.half**2 + np.zeros_like(curve)
    near, far = slice(None, -size[0]), slice(size[0], None)
    return np.asarray(np.abs(curve[far] - curve[near]) / np.sqrt(gain[near] ** 2 + gain[far] ** 2))
