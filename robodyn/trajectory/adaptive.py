"""Derivatives of motions with corners, from noisy samples: of all windows that cover a sample, those that know most.

A polynomial of degree d is fitted to a window, and one of degree d + 2 beside it. By how much the two differ is what
the window leaves in doubt; noise, judged by what the fit leaves, is the rest of the error bar. A sample belongs to the
last third of some windows, to the middle third of others, and to the first third of others again. Of each kind that
with the least bar counts, so that windows end at corners. Where the one before a sample and the one after it disagree,
as at jumps, the bar covers both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robodyn.support.floats import Floats
from robodyn.trajectory.motion import NOISE
from robodyn.trajectory.windows import SIZES, Windows, all_windows

CLEAR = 3.0
"""Doubt over noise, up to which a window is not suspected to have a jump in it."""
ALIKE = 8.0
"""Ratio of two bars, up to which neither of two windows that disagree is taken for the better one."""


EDGE = 2.0
"""Of what an acceleration changes by from one sample to the next: how much that may be off at either end of a window,
since positions do not tell a corner just before the last sample."""


class Rate(NamedTuple):
    """A derivative (N,) with its standard deviation by noise, and by how much it may be off in 19 of 20 cases."""

    value: Floats
    noise: Floats
    off: Floats


class _Best(NamedTuple):
    """Of the first, middle and last thirds of windows (3, N): value, noise, bar, slope, what noise has in the bar."""

    value: Floats
    noise: Floats
    bar: Floats
    slope: Floats
    noisy: Floats


def rates(
    time: Floats | None,
    values: Floats,
    turns: Floats | None,
    noise: tuple[float, ...],
    order: int,
    other: tuple[Floats, Rate],
    first: int,
    noisy: bool,
) -> tuple[Floats, Rate]:
    """Return the first derivative of a column, and that of the order with its bars.

    Args:
        time: (N,) s, or None for samples a unit apart; values: (N,); turns: (N,) of 2 pi that they are ahead by.
        noise: standard deviation for windows of each of `windows.SIZES` that is to be tried.
        order: 1 or 2, of the derivative that windows are chosen by.
        other: the same otherwise found, which is weighed with what windows tell.
        first: of the samples, counted in the table; noisy: whether there is more than rounding in the data.
    """
    shape = 3, len(values)
    best = _Best(*(np.full(shape, start) for start in (0.0, np.inf, np.inf, 0.0, np.inf)))
    of_length = dict(zip((parts * part for parts, part in SIZES), noise, strict=False))
    for fits in all_windows(time, values, turns, first, len(noise)):
        for degree in range(order, min(order + 3, len(fits.basis.on) - 2)):
            _improve(best, fits, degree, order, of_length[fits.length], noisy)
    return _weighed(best, other)


def _improve(best: _Best, fits: Windows, degree: int, order: int, sigma: float, noisy_data: bool) -> None:
    """Take what fits of a degree tell of the samples that they know better than those before."""
    basis, shape = fits.basis, (fits.length, len(fits.starts))
    which = basis.curve if order == 2 else basis.slope
    unit = fits.half**order
    terms = [fits.coefficients[k] * which[k] for k in range(order, degree + 3)]
    value = sum(terms[:-2]) + np.zeros(shape)
    doubt = np.maximum(np.abs(terms[-2]), np.abs(terms[-2] + terms[-1])) / unit
    scale = fits.scatter(degree + 2, sigma, noisy_data) / unit
    edge = np.zeros(shape)
    for sample, inner in ((0, 1), (-1, -2)):
        edge[sample] = EDGE * np.abs(value[sample] - value[inner]) / unit
    slope = sum(fits.coefficients[k] * basis.slope[k] for k in range(1, degree + 1)) / fits.half
    gains = (np.sqrt((which[order : top + 1] ** 2).sum(axis=0)) for top in (degree, degree + 2))
    own, noisy = (np.broadcast_to(gain * scale, shape) for gain in gains)
    third = fits.parts // 3
    for kind, parts in enumerate(((0, third), (third, fits.parts - third), (fits.parts - third, fits.parts))):
        _take(best, kind, fits, parts, (value / unit, own, NOISE * noisy + edge, slope, NOISE * noisy), doubt)


def _take(
    best: _Best, kind: int, fits: Windows, parts: tuple[int, int], found: tuple[Floats, ...], doubt: Floats
) -> None:
    """Take in a third of every window: the bar is that of noise and the largest doubt in the third."""
    part, count = fits.length // fits.parts, len(fits.starts)
    own = slice(parts[0] * part, parts[1] * part)
    largest = doubt[own].max(axis=0)
    if count == 1:
        stretches = [(own, slice(fits.starts[0] + own.start, fits.starts[0] + own.stop))]
    else:
        begins = [k * part for k in range(*parts)]
        at = [int(fits.starts[0]) + begin for begin in begins]
        stretches = [(slice(k, k + part), slice(row, row + part * count)) for k, row in zip(begins, at, strict=True)]
    for samples, rows in stretches:
        cut = [each[samples] for each in found]
        cut[2] = cut[2] + largest
        flat = [each.T.ravel() for each in cut]
        old = best.bar[kind, rows]
        better = (flat[2] < old) & (np.abs(flat[0] - best.value[kind, rows]) <= flat[2] + old)
        for whole, new in zip(best, flat, strict=True):
            np.copyto(whole[kind, rows], new, where=better)


def _weighed(best: _Best, other: tuple[Floats, Rate]) -> tuple[Floats, Rate]:
    """Return the mean of all, weighed by their bars; where those before and after disagree, what lies between."""
    slope, rate = other
    bars = np.vstack((best.bar, rate.off))
    least = bars.min(axis=0)
    values = np.vstack((best.value, rate.value))
    surest = np.take_along_axis(values, bars.argmin(axis=0)[None], axis=0)
    weights = np.where(bars == least, 1.0, (least / np.where(bars > 0.0, bars, 1.0)) ** 2)
    weights[np.abs(values - surest) > bars + least] = 0.0
    weights /= weights.sum(axis=0)
    means = []
    for own, more in ((best.value, rate.value), (best.noise, rate.noise), (best.bar, rate.off), (best.slope, slope)):
        each = np.where(np.isfinite(bars), np.vstack((own, more)), 0.0)
        means.append(sum(weights[k] * each[k] for k in range(len(bars))))
    value, noise, off, of_slope = means
    ends = [0, 2]
    left, right = best.bar[ends]
    clear = (best.bar <= CLEAR * best.noisy)[ends].all(axis=0)
    alike = np.maximum(left, right) <= ALIKE * np.minimum(left, right)
    apart = np.abs(best.value[0] - best.value[2]) > left + right
    jump = apart & (clear | alike)
    reach = np.where(jump, np.minimum(left, right), 0.0)
    low, high = (best.value[ends] - reach).min(axis=0), (best.value[ends] + reach).max(axis=0)
    value, off = np.where(jump, 0.5 * (low + high), value), np.where(jump, 0.5 * (high - low), off)
    return of_slope, Rate(value, noise, off)
