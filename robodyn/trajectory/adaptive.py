"""Derivatives of motions with corners, from noisy samples: for every sample the longest window that noise allows for.

Lepski's method (Lepski 1991; Goldenshluger and Nemirovski 1997): windows before, after and about a sample grow until a
fit contradicts a shorter one by more than noise explains. So windows end at corners, where one before and one after
disagree about the derivative, and the error bar covers both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from robodyn.support.floats import Floats
from robodyn.trajectory.windows import WIDEST, Fits, fits, lengths

CONTRADICTION = 2.5
"""Standard deviations of either of two fits, within which they agree."""
BACK = 3
"""Steps back from the longest window without a contradiction, at which half as much of the error is not noise."""
AGREE = 2.0
"""Standard deviations about the fit of lower degree, within which one of higher degree has to begin."""
NOISE = 3.0
"""Standard deviations of the noise in a bar."""
TRUST = (1.0, 1.5, 2.0)
"""Bars of fits of the lowest degree, one more, two more: these follow corners that they should not."""
JUMP = 0.8
"""Of the bars before and after a sample together: where derivatives differ by more, one may not choose."""
NEAR, WIDER = 6, 3.0
"""A bar is wide if it is so many times the least among so many samples on either side."""


FAMILIES = ((1, 0), (-1, 0), (0, 0), (1, 1), (-1, 1), (0, 2))
"""Windows before (1), after (-1) or about (0) a sample, and the degree beyond the order of the derivative."""


class Rate(NamedTuple):
    """A derivative (N,) with its standard deviation by noise, and by how much it may be off in 19 of 20 cases."""

    value: Floats
    noise: Floats
    off: Floats


@dataclass(frozen=True)
class _Family:
    """Fits of one degree on windows before (1), after (-1) or about (0) every sample.

    Attributes:
        values, noises, slopes: (lengths, N) of the derivative, NaN and infinity where a window does not fit in, and the
            first derivative of the same fits.
        lengths: of the windows, filled as they come.
    """

    side: int
    extra: int
    values: Floats
    noises: Floats
    slopes: Floats
    lengths: list[int]


class _Chosen(NamedTuple):
    """Of a family at every sample: value, noise, what growing windows changed, slope, the window, if it was tested."""

    value: Floats
    noise: Floats
    change: Floats
    slope: Floats
    length: NDArray[np.int64]
    tested: NDArray[np.bool_]


Known = list[tuple[_Chosen, float, int]]


def rates(
    time: Floats | None,
    values: Floats,
    turns: Floats | None,
    noise: Sequence[float],
    order: int,
    spline: tuple[Floats, Rate] | None = None,
    louder: Floats | float = 1.0,
) -> tuple[Floats, Rate, int]:
    """Return the first derivative of a column, that of the order with its bars, and the longest window of use.

    Args:
        time: (N,) s, or None for samples a unit apart; values: (N,); turns: (N,) of 2 pi that they are ahead by.
        noise: standard deviation for windows of every length (`windows.lengths`) that is to be tried.
        order: 1 or 2, of the derivative that windows are chosen by.
        spline: the same otherwise found, which is weighed with the others.
        louder: (N,) how many times as large the noise is.
    """
    families = [_family(side, extra, len(noise), len(values)) for side, extra in FAMILIES]
    widest = lengths(WIDEST)[len(noise) - 1]
    for scale, fit in zip(noise, fits(time, values, turns, widest), strict=False):
        _gather(families, fit, order, scale)
    base: dict[int, _Chosen] = {}
    known = []
    for family in families:
        if family.lengths:
            family.noises[:] *= louder
            chosen = _longest(family, base.get(family.side))
            base.setdefault(family.side, chosen)
            known.append((chosen, TRUST[family.extra], family.side))
    useful = max((int(each.length.max(initial=0)) for each, _, _ in known), default=0)
    slope, rate = _weighed(known, spline, len(values))
    return slope if order > 1 else rate.value, rate, useful


def _family(side: int, extra: int, count: int, samples: int) -> _Family:
    shape = count, samples
    return _Family(side, extra, np.full(shape, np.nan), np.full(shape, np.inf), np.zeros(shape), [])


def _gather(families: list[_Family], fit: Fits, order: int, scale: float) -> None:
    """Add the fits of one length of windows to the families."""
    for side, begin, at in ((1, fit.length - 1, 1.0), (-1, 0, -1.0), (0, fit.length // 2, fit.middle)):
        own = {order + family.extra: family for family in families if family.side == side}
        slopes = {} if order == 1 else {degree: value for degree, value, _ in fit.derivative(1, at) if degree in own}
        for degree, derivative, gain in fit.derivative(order, at):
            if degree in own:
                family, row = own[degree], len(own[degree].lengths)
                rows = slice(begin, begin + len(derivative))
                family.values[row, rows] = derivative
                family.noises[row, rows] = np.where(np.isfinite(derivative), gain * scale, np.inf)
                family.slopes[row, rows] = slopes.get(degree, derivative)
                family.lengths.append(fit.length)


def _longest(family: _Family, near: _Chosen | None) -> _Chosen:
    """Return the fits BACK steps before the longest windows that contradict none that is shorter.

    Args:
        near: of lower degree, which the first fits have to begin near.
    """
    E, S, count = family.values, family.noises, len(family.lengths)
    low, high = np.full(E.shape[1], -np.inf), np.full(E.shape[1], np.inf)
    if near is not None:
        known = np.isfinite(near.noise)
        low[known] = (near.value - AGREE * near.noise)[known]
        high[known] = (near.value + AGREE * near.noise)[known]
    top, agree = np.full(E.shape[1], -1), np.full(E.shape[1], True)
    for row in range(count):
        np.fmax(low, E[row] - CONTRADICTION * S[row], out=low)
        np.fmin(high, E[row] + CONTRADICTION * S[row], out=high)
        agree &= (low <= high) & np.isfinite(S[row])
        if not agree.any():
            break
        top += agree
    column, pick, last = np.arange(E.shape[1]), np.maximum(top - BACK, 0), count - 1
    none = top < 0
    value, noise = E[pick, column], np.where(none, np.inf, S[pick, column])
    change = np.zeros_like(value)
    for k in range(1, BACK + 1):
        np.maximum(change, np.abs(E[np.minimum(pick + k, last), column] - value), out=change)
    change[~np.isfinite(change)] = np.inf
    length = np.where(none, 0, np.array(family.lengths)[np.minimum(np.maximum(top, 0) + 1, last)])
    value = np.where(np.isfinite(noise), value, 0.0)
    return _Chosen(value, noise, change, family.slopes[pick, column], length, top >= BACK)


def _weighed(known: Known, spline: tuple[Floats, Rate] | None, count: int) -> tuple[Floats, Rate]:
    """Return the mean of all fits, weighed by their bars; where those before and after disagree, what lies between."""
    fits_of = [(each.value, each.noise, _bar(each, trust), each.slope, each.tested) for each, trust, _ in known]
    if spline is not None:
        slope, rate = spline
        fits_of = [(*of[:2], np.where(of[4], of[2], np.inf), *of[3:]) for of in fits_of]
        fits_of.append((rate.value, rate.noise, rate.off, slope, np.full(count, True)))
    least = np.full(count, np.inf)
    for _, _, bar, _, _ in fits_of:
        np.fmin(least, bar, out=least)
    total, mean, noise, of_slope = (np.zeros(count) for _ in range(4))
    for value, own, bar, slope, _ in fits_of:
        used = np.isfinite(bar)
        weight = np.where(bar == least, 1.0, (least / np.where(bar > 0.0, bar, 1.0)) ** 2)
        total += np.where(used, weight, 0.0)
        mean += np.where(used, weight * value, 0.0)
        noise += np.where(used, weight * own, 0.0)
        of_slope += np.where(used, weight * slope, 0.0)
    mean, noise, of_slope, off = mean / total, noise / total, of_slope / total, least
    for value, _, bar, _, tested in fits_of:
        off = np.maximum(off, np.where(np.isfinite(bar) & tested, np.abs(value - mean) - bar, 0.0))
    return of_slope, _at_jumps(known, Rate(mean, noise, off))


def _bar(chosen: _Chosen, trust: float) -> Floats:
    return trust * (NOISE * chosen.noise + chosen.change)


def _at_jumps(known: Known, rate: Rate) -> Rate:
    """Return the rate with the middle of both where those before and after a sample disagree."""
    ends = []
    for side in (1, -1):
        own = [(each, trust) for each, trust, at in known if at == side]
        if not own:
            return rate
        bars = np.array([np.where(c.tested, _bar(c, trust), np.inf) for c, trust in own])
        best, column = bars.argmin(axis=0), np.arange(bars.shape[1])
        ends.append((np.array([c.value for c, _ in own])[best, column], bars[best, column]))
    (before, left), (after, right) = ends
    jump = np.isfinite(left + right) & (np.abs(before - after) > JUMP * (left + right))
    between = 0.5 * (before + after)
    wide = np.maximum(np.abs(before - between) + left, np.abs(after - between) + right)
    return Rate(np.where(jump, between, rate.value), rate.noise, np.where(jump, wide, rate.off))


def smoothed(rate: Rate) -> Rate:
    """Return the rate moved within wide bars towards the samples nearby that are known better."""
    bars, count = np.where(np.isfinite(rate.off), rate.off, np.inf), len(rate.off)
    if not count:
        return rate
    around = sliding_window_view(np.pad(bars, NEAR, constant_values=np.inf), 2 * NEAR + 1)
    least = around.min(axis=1)
    wide = (bars > WIDER * least) & (least > 0.0)
    rows = np.flatnonzero(wide)
    weights = (least[rows, None] / around[rows]) ** 2
    values = sliding_window_view(np.pad(rate.value, NEAR), 2 * NEAR + 1)[rows]
    total, weight = np.zeros(len(rows)), np.zeros(len(rows))
    for k in range(2 * NEAR + 1):
        total, weight = total + weights[:, k] * values[:, k], weight + weights[:, k]
    value, off = rate.value.copy(), rate.off.copy()
    near = np.clip(total / weight, value[rows] - bars[rows], value[rows] + bars[rows])
    off[rows] += np.abs(near - value[rows])
    value[rows] = near
    return Rate(value, rate.noise, off)
