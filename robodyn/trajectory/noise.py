"""How noisy sampled signals are: the grid they lie on, and the noise that differences reveal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from robodyn.support.floats import Floats
from robodyn.trajectory.derivatives import equal_spacing
from robodyn.trajectory.windows import BASES, fits, lengths

HIGHEST = 14
"""Highest difference looked at."""
_ORDERS = range(1, HIGHEST + 1)
_LEVEL = 0.7
"""Ratio of successive differences above which they no longer fall: white noise has 1, n samples a period sin(pi/n)"""
_STILL = 32
FINEST_ENCODER = 2.0 * math.pi / 1024
_APART = 18
_HIGH, _AROUND, _CHANCE = 8, 16, 1.5
_COLOURED = 1.5
"""Power of a window's length: noise of steeper spectra is taken for motion"""
_UNSURE = 2.0
_MEDIAN = 0.6744897501960817


def quantum(values: Floats) -> float:
    """The step of the grid on which all values lie (decimals, encoder counts), 0 if they lie on none.

    The greatest common divisor of the gaps between distinct values, by Euclid's algorithm with a tolerance of 1 %.

    Args:
        values: (N,).
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


def weights(time: Floats) -> list[Floats]:
    """For p = 1..HIGHEST the 2-norm (N - p,) of the weights of the p-th divided differences of stamps a unit apart."""
    if equal_spacing(time):
        return [np.full(len(time) - p, math.sqrt(math.comb(2 * p, p)) / math.factorial(p)) for p in _ORDERS]
    norms = []
    table = np.ones((len(time), 1))
    for p in _ORDERS:
        gap = (time[p:] - time[:-p])[:, None]
        new = np.zeros((len(time) - p, p + 1))
        new[:, 1:] = table[1:]
        new[:, :-1] -= table[:-1]
        table = new / gap
        norms.append(np.sqrt((table**2).sum(axis=1)))
    return norms


def differences(time: Floats, values: Floats, norms: list[Floats]) -> list[Floats]:
    """For p = 1..HIGHEST the p-th divided differences, scaled to keep the standard deviation of white noise."""
    found = []
    for p, norm in enumerate(norms, start=1):
        values = np.diff(values) / (time[p:] - time[:-p])
        found.append(values / norm)
    return found


def moving(values: Floats) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Whether each sample has a change within 32 samples; resting stretches say nothing about noise."""
    changes = np.concatenate(([0], np.cumsum(np.diff(values) != 0.0)))
    last = len(changes) - 1
    index = np.arange(len(values))
    return np.asarray(changes[np.minimum(index + _STILL, last)] > changes[np.maximum(index - _STILL, 0)])


@dataclass(frozen=True)
class Noise:
    """White noise found in a signal: standard deviation, grid, and why no noise is claimed where it might be."""

    sigma: float
    quantum: float
    warning: str = ""


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
        unit = even if equal_spacing(time) else (time - time[0]) / float(np.median(np.diff(time)))
        active = moving(values)
        jumps.append(np.abs(np.diff(values))[active[1:]])
        for p, difference in enumerate(differences(unit, values, weights(unit)), start=1):
            scaled[p - 1].append(np.abs(difference[active[: len(difference)]]))
    sizes = [np.concatenate(parts) if parts else np.zeros(0) for parts in scaled]
    if not sizes[-1].size:
        return Noise(0.0, grid)
    fine = 0.0 < grid <= FINEST_ENCODER
    sigma = _floor([float(np.median(size)) / _MEDIAN for size in sizes])
    if fine:
        spread = _floor([float(np.sqrt((size**2).mean())) for size in sizes])
        sigma = max(sigma, min(spread, grid / math.sqrt(12.0)))
    return _judge(sigma, grid, fine, np.concatenate(jumps), raw)


def _floor(levels: list[float]) -> float:
    """Where levels of rising order stop falling, 0 if they do not."""
    for p in range(1, HIGHEST - 2):
        if levels[p + 1] > _LEVEL * levels[p] and levels[p + 2] > _LEVEL * levels[p + 1]:
            return min(levels[p:])
    return 0.0


def _judge(sigma: float, grid: float, fine: bool, jumps: Floats, raw: Floats) -> Noise:
    leaps = jumps[jumps > 0.0]
    if 0 < 2 * len(leaps) < len(jumps) and not (fine and float(np.median(leaps)) <= 4.0 * grid):
        return Noise(0.0, grid, "most samples repeat the one before, then jump; steps are not smoothed")
    largest, span = float(np.abs(raw).max()), float(raw.max() - raw.min())
    if sigma <= 8.0 * float(np.finfo(np.float64).eps) * largest:
        return Noise(0.0, grid)
    if sigma > 0.01 and sigma > 0.01 * span:
        return Noise(0.0, grid, "sampled too coarsely to tell motion from noise; not smoothed")
    return Noise(sigma, grid)


def louder(time: Floats, values: Floats, sigma: float) -> Floats:
    """Return (N,) how many times the noise about each sample exceeds that of the table, 1 where it does not.

    Stamps that software takes late make noise that grows with the speed. The median over 33 samples of a high
    difference counts, so that no corner does.
    """
    found = np.ones(len(values))
    if len(values) < _HIGH + 2 * _AROUND or sigma == 0.0:
        return found
    even = np.arange(len(time), dtype=np.float64)
    unit = even if equal_spacing(time) else (time - time[0]) / float(np.median(np.diff(time)))
    off = np.abs(differences(unit, values, weights(unit)[:_HIGH])[-1])
    level = np.median(sliding_window_view(np.pad(off, _AROUND, mode="edge"), 2 * _AROUND + 1), axis=1)
    first = _HIGH // 2
    found[first : first + len(level)] = np.maximum(level / (_MEDIAN * _CHANCE * sigma), 1.0)
    found[:first], found[first + len(level) :] = found[first], found[first + len(level) - 1]
    return found


def by_window(runs: Sequence[tuple[Floats, Floats]], sigma: float, widest: int) -> tuple[float, ...]:
    """Return what white noise would have to be to scatter the fits on windows of every length as the data's does.

    Of neighbouring windows that share no sample the second derivatives of parabolas differ by noise, and by what the
    motion does; the median over a table is the noise's as long as it grows no faster with the length than that of
    coloured noise. From where it does the last value counts.

    Args:
        runs: (time (N,), values (N,)) of stretches of the table; sigma: the least that is returned.
    """
    sizes: dict[int, list[Floats]] = {}
    for time, values in runs:
        spacing = equal_spacing(time)
        for fit in fits(None if spacing else time, values, None, min(widest, len(values) // _APART)):
            _, curve, gain = next(fit.derivative(2, fit.middle))
            near, far = curve[: -fit.length], curve[fit.length :]
            both = (
                np.sqrt(gain[: -fit.length] ** 2 + gain[fit.length :] ** 2)
                if isinstance(gain, np.ndarray)
                else gain * math.sqrt(2.0)
            )
            sizes.setdefault(fit.length, []).append(np.abs(far - near) / both)
    found: list[float] = []
    before: tuple[float, float] | None = (0.5 * BASES[0], sigma)
    for length in lengths(widest):
        if before is not None and length in sizes:
            off = np.concatenate(sizes[length])
            level = float(np.median(off[off > 0.0])) / _MEDIAN if (off > 0.0).any() else 0.0
            shorter, least = before
            if level > max(least, sigma) * (length / shorter) ** _COLOURED:
                before = None
            else:
                sigma = max(sigma, level * (1.0 - _UNSURE * math.sqrt(length / len(off))))
                before = length, level
        found.append(sigma)
    return tuple(found)
