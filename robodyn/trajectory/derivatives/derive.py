"""Missing velocities and accelerations: how each is derived, and how far it can be trusted.

Of motions with corners, from noisy samples, those windows count that know most. A polynomial of degree d is fitted to a
window, and one of degree d + 2 beside it. By how much the two differ is what the window leaves in doubt; noise, judged
by what the fit leaves, is the rest of the error bar. Of the windows that have a sample in their first, middle and last
third, each time that with the least bar counts, so that windows end at corners. Where the one before a sample and the
one after it disagree, as at jumps, the bar covers both.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, islice
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from robodyn.errors import TrajectoryError
from robodyn.support.floats import Floats, median
from robodyn.trajectory.derivatives.derivative_selection import NEAR, Selection, select
from robodyn.trajectory.derivatives.differentiate import (
    SIZES,
    SPLINE,
    Method,
    Windows,
    all_windows,
    differentiate,
    equal_spacing,
)
from robodyn.trajectory.derivatives.groups import Group, source, straight, turns_ahead
from robodyn.trajectory.motion import FEW, NOISE, Derivation, JointDerivation, Sampling, Trajectory


@dataclass(frozen=True)
class Plan:
    """The groups to derive, how each is derived and trusted, and the account of it."""

    groups: tuple[Group, ...]
    selections: tuple[Selection, ...]
    derivation: Derivation
    notes: tuple[str, ...]

    @property
    def halo(self) -> int:
        return max((selection.halo for selection in self.selections), default=0)

    @property
    def resolutions(self) -> dict[int, tuple[float, float]]:
        """Of columns of q that are derived one by one: step of their grid, and standard deviation of their noise."""
        pairs = zip(self.groups, self.selections, strict=True)
        return {x.rows[0]: (s.noise.quantum, s.noise.sigma) for x, s in pairs if x.source == "q" and len(x.rows) == 1}


def plan(groups: Sequence[Group], pieces: Sequence[Trajectory], mode: str, encoder_error: float = 0.0) -> Plan:
    """How to derive each group, by `pieces` that stand for the table; mode and encoder's error as of `select`."""
    selections, accounts, notes = [], [], []
    for group in groups:
        runs = [(piece.time, getattr(piece, group.source)[:, group.rows], straight(group, piece)) for piece in pieces]
        with np.errstate(all="ignore"):
            found = select(runs, group.order, mode, encoder_error if group.source == "q" else 0.0)
        text, noise = found.method.text, found.noise
        turn = 2.0 if group.kind == "quaternion" else 1.0  # w = 2 vec(conj(Q) Qd) doubles the noise of Q's components
        rates = (text if group.velocity else "given", text if group.acceleration else "given")
        selections.append(found)
        accounts.append(JointDerivation(group.name, *rates, group.source, noise.quantum, noise.sigma, turn * found.std))
        notes += [f"{group.name}: {noise.warning}"] * bool(noise.warning)
    return Plan(tuple(groups), tuple(selections), Derivation(tuple(accounts)), tuple(notes))


def derive(samples: Trajectory, plan: Plan) -> tuple[Trajectory, Floats, Floats]:
    """The samples with missing columns of qd and qdd filled in, and (N, n) each of qdd: the standard deviation by noise
    and by how much it may be off; raises where stamps almost coincide, or a pause exceeds the window that smooths."""
    steps = np.diff(samples.time)
    methods = [selection.method for selection in plan.selections]
    window = min((method.window for method in methods if method.kind in {"savgol", "local"}), default=0)
    if window and len(steps) and steps.max() > window * median(steps):
        # a polynomial through the ends of two recordings means nothing, and its equations are singular
        row = samples.first_row + int(np.argmax(steps)) + 1
        what = f"row {row}: a pause of {steps.max():.6g} s is longer than the window that smooths the noise"
        raise TrajectoryError(what, remedy="split the trajectory there, or use --derivatives central")
    qd, qdd = samples.qd.copy(order="F"), samples.qdd.copy(order="F")
    noise, off = np.zeros_like(qdd), np.zeros_like(qdd)
    with np.errstate(all="ignore"):
        for group, selection in zip(plan.groups, plan.selections, strict=True):
            values = source(group, samples)
            turns = turns_ahead(values) if group.kind == "continuous" else None
            first, second = estimated(samples.time, values, turns, selection, samples.first_row - 1)
            if group.kind == "quaternion":
                first, second = _of_body(values, first), _of_body(values, second)
            for component, column in group.velocity:
                qd[:, column] = first.value[:, component]
            highest = first if group.source == "qd" else second
            for component, column in group.acceleration:
                for whole, part in zip((qdd, noise, off), highest, strict=True):
                    whole[:, column] = part[:, component]
    for values in (qd, qdd):
        if not np.isfinite(values).all():
            row = samples.first_row + int(np.argwhere(~np.isfinite(values))[0][0])
            raise TrajectoryError(f"row {row}: the derivative is not finite", remedy="are two stamps almost equal?")
    return replace(samples, qd=qd, qdd=qdd), noise, off


def _of_body(Q: Floats, rate: Rate) -> Rate:
    """2 vec(conj(Q) rate) (N, 3) of unit quaternions x y z w: of Qd w, of Qdd wd, in body axes; the parts of the rate
    along Q, which come from noise in the norm, drop out. Each component is off by what all together are."""
    vector, scalar, value = Q[:, :3], Q[:, 3:], rate.value
    body = 2.0 * (scalar * value[:, :3] - value[:, 3:] * vector - np.cross(vector, value[:, :3]))
    noise, off = (np.repeat(2.0 * np.sqrt((part**2).sum(axis=1, keepdims=True)), 3, axis=1) for part in rate[1:])
    return Rate(body, 0.5 * noise, off)


def sampling(samples: Trajectory, plan: Plan, noise: Floats, off: Floats, rows: slice) -> Sampling:
    """By how much accelerations of some rows of a derived block may be off, with `noise` and `off` of all rows; below
    24 rows any motion that rests in every row is within the bars."""
    if few := len(samples) < FEW:
        guess, steps = np.zeros_like(off), np.diff(samples.time)[:, None]
        for group in plan.groups:  # a motion that rests in every row reaches 6 |dq| / h^2, 2 |dqd| / h
            moved = np.abs(np.diff(straight(group, samples), axis=0))
            if group.kind == "quaternion":
                moved = 2.0 * np.sqrt((moved**2).sum(axis=1, keepdims=True)) * np.ones(3)
            needed = 2.0 * moved / steps if group.source == "qd" else 6.0 * moved / steps**2
            for component, column in group.acceleration:
                guess[:-1, column] = needed[:, component]
                guess[1:, column] = np.maximum(guess[1:, column], needed[:, component])
        off = np.maximum(off, guess + np.abs(samples.qdd))
    derived = {column for group in plan.groups for _, column in group.acceleration}
    off[:, [column for column in range(off.shape[1]) if column not in derived]] = 0.0
    off, noise, qdd = off[rows], noise[rows], samples.qdd[rows]
    with np.errstate(over="ignore"):
        off_squares, squares = ((values**2).sum(axis=0) for values in (off, qdd))
    if len(samples) >= NOISY:  # errors of noisy columns come of noise, not of the number of samples
        pairs = zip(plan.groups, plan.selections, strict=True)
        off_squares[[column for group, own in pairs if own.noisy for _, column in group.acceleration]] = 0.0
    return Sampling(off, noise, off_squares, squares, few and any(group.velocity for group in plan.groups))


INNER, END, WIDER = 3.0, 8.0, 3.0
"""Bars of one window for all samples: standard deviations of the noise, in the middle and near an end, and how often
counts what a wider window changes."""
CORNER = 1e-3  # of the rms of a derivative: where the spline may be off by more, there may be a corner
FEWEST = 6  # samples of which half are enough for a second derivative
_ROWS, _REACHES = 8192, 4
"""Rows, and lengths of the longest window, that are looked at together: their arrays stay in the processor's cache."""
NOISY = 128  # rows of a table below which what looks like noise may as well be the motion
CLEAR = 3.0  # doubt over noise, up to which a window is not suspected to have a jump in it
ALIKE = 8.0  # ratio of two bars, up to which neither of two windows that disagree is taken for the better one
EDGE = 2.0
"""Of what an acceleration changes by from one sample to the next: how much that may be off at either end of a window,
since positions do not tell a corner just before the last sample."""


class Rate(NamedTuple):
    """A derivative (N,) with its standard deviation by noise, and by how much it may be off in 19 of 20 cases."""

    value: Floats
    noise: Floats
    off: Floats


def estimated(
    time: Floats, values: Floats, turns: Floats | None, selection: Selection, first: int = 0
) -> tuple[Rate, Rate]:
    """The first and second derivatives (N, c) of values (N, c), with error bars; `first` sample counted in the table.
    Bars cover 19 of 20 errors of peaks, for motions of all kinds (`accuracy/test_bars_of_motions.py`)."""
    method, sigma = selection.method, selection.sigma
    if method.kind == "savgol" and selection.smooth and not selection.forced:
        # what one window gives, with what the noise leaves, and what a window a third wider changes nearby
        wider, ends, near = method.window * 4 // 3 | 1, min(method.window // 2, len(time) // 2), method.window // 4
        times = np.full((len(time), 1), INNER)
        times[:ends] = times[len(time) - ends :] = END
        narrow = differentiate(time, values, method, turns)
        broad = differentiate(time, values, replace(method, window=wider), turns)
        rates = []
        for value, other, noise in zip(narrow, broad, _noises(time, method, sigma), strict=True):
            padded = np.pad(np.abs(other - value), ((near, near), (0, 0)))
            change = sliding_window_view(padded, 2 * near + 1, axis=0).max(axis=-1)
            rates.append(Rate(value, noise + 0.0 * value, times * noise + WIDER * change))
        return rates[0], rates[1]
    best = _best(time, values, turns, selection, first)
    if not selection.forced:
        return best
    own = zip(differentiate(time, values, method, turns), _noises(time, method, sigma), best, strict=True)
    slopes, curves = (
        Rate(value, noise + 0.0 * value, np.abs(value - each.value) + each.off) for value, noise, each in own
    )
    return slopes, curves


def _noises(time: Floats, method: Method, sigma: float) -> list[Floats]:
    """(N, 1) the standard deviations that noise gives both derivatives."""
    spacing, count, found = np.float64((time[-1] - time[0]) / max(1, len(time) - 1)), len(time), []
    for order, gains in enumerate(method.gains, start=1):
        noise, near = np.full(count, gains[-1]), gains[:-1][: count // 2]
        noise[: len(near)], noise[count - len(near) :] = near, near[::-1]
        found.append((noise * sigma / spacing**order)[:, None])
    return found


def _best(time: Floats, values: Floats, turns: Floats | None, selection: Selection, first: int) -> tuple[Rate, Rate]:
    """The quintic spline where it can be trusted, and what local polynomials make of it elsewhere."""
    spline, order = _spline(time, values, turns, selection.sigma), selection.order
    changes = [rate.off - NOISE * rate.noise for rate in spline]
    wanted = changes[order - 1] > CORNER * selection.level
    if selection.noisy:
        wanted[:] = True
    spacing, scale = equal_spacing(time), dict(zip((n * part for n, part in SIZES), selection.scale, strict=False))
    unit, reach = spacing or 1.0, max(scale)
    blocks = np.array_split(np.arange(len(time)), -(-len(time) // max(_ROWS, _REACHES * reach)))
    for k, block in ((k, block) for k in range(values.shape[1]) for block in blocks if wanted[block, k].any()):
        near = slice(max(0, block[0] - reach), min(len(time), block[-1] + 1 + reach))
        turned, ends = None if turns is None else turns[near, k], (near.start == 0, near.stop == len(time))
        stamps = None if spacing else time[near]
        windows = all_windows(stamps, values[near, k], turned, first + near.start, len(scale), ends)
        best = _of_windows(windows, wanted[near, k], order, scale, selection.noisy)
        rows, parts = wanted[block, k], [x[block, k] for x in (spline[0].value, *spline[order - 1])]
        units = unit, *[unit**order] * 3
        own = _Best(*(each[:, block - near.start] for each in best))
        slope, found = _weighed(own, parts[0] * unit, Rate(*(part * unit**order for part in parts[1:])))
        for whole, part, each in zip((spline[0].value, *spline[order - 1]), (slope, *found), units, strict=True):
            whole[block[rows], k] = part[rows] / each
    if len(time) < NOISY:
        for found, least in zip(spline, changes, strict=True):
            np.maximum(found.off, least, out=found.off)
    return spline


def _spline(time: Floats, values: Floats, turns: Floats | None, sigma: float) -> tuple[Rate, Rate]:
    """The quintic spline, with twice the largest change nearby that leaving out every second sample makes: 32 times the
    error of a smooth motion, and about the error at corners of the velocity."""
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


class _Best(NamedTuple):
    """Of the first, middle and last thirds of windows (3, N): value, noise, bar, slope, what noise has in the bar."""

    value: Floats
    noise: Floats
    bar: Floats
    slope: Floats
    noisy: Floats


def _of_windows(
    windows: Iterable[Windows], wanted: NDArray[np.bool_], order: int, scale: Mapping[int, float], noisy_data: bool
) -> _Best:
    """What the windows tell of the wanted samples, each time the one that knows more than those before. Of those found
    before the last, only values and bars are computed."""
    shape = 3, len(wanted)
    best = _Best(*(np.full(shape, start) for start in (0.0, np.inf, np.inf, 0.0, np.inf)))
    best.bar[:, ~wanted] = -np.inf
    sources, known = np.full(shape, -1), 0  # numbers of the samples of windows, each fit's after those before
    found: list[tuple[int, Windows, int, Floats, Floats, Floats]] = []
    for fits in windows:
        which = fits.basis.curve if order == 2 else fits.basis.slope
        unit, value = fits.half**order, np.zeros(1)
        terms = [fitted * part for fitted, part in zip(fits.coefficients[order:], which[order:], strict=True)]
        gains = [np.sqrt(squares) for squares in accumulate(which[order:] ** 2)]
        for k, white in enumerate(islice(fits.scatters(order + 2, scale[fits.length], noisy_data), 3)):
            value, scatter = value + terms[k], white / unit
            doubt = terms[k + 1] + terms[k + 2]
            np.maximum(np.abs(doubt, out=doubt), np.abs(terms[k + 1], out=terms[k]), out=doubt)
            noisy = gains[k + 2] * scatter
            noisy *= NOISE
            for sample, inner in ((0, 1), (-1, -2)):
                noisy[sample] += EDGE * np.abs(value[sample] - value[inner]) / unit
            _take(best, sources, known, fits, (value / unit, noisy, doubt / unit))
            found.append((known, fits, order + k, gains[k], gains[k + 2], scatter))
            known += value.size
    for first, fits, degree, gain, more, scatter in reversed(found):
        at = np.nonzero(sources >= first)
        place, window = divmod(sources[at] - first, len(scatter))
        sources[at] = -1
        own = window * (gain.shape[1] > 1)
        best.noise[at], best.noisy[at] = (part[place, own] * scatter[window] for part in (gain, more))
        slope = sum(fits.coefficients[k, window] * fits.basis.slope[k, place, own] for k in range(1, degree + 1))
        best.slope[at] = slope / np.broadcast_to(fits.half, scatter.shape)[window]
    np.multiply(best.noisy, NOISE, out=best.noisy)
    return best


def _take(
    best: _Best, sources: NDArray[np.intp], known: int, fits: Windows, found: tuple[Floats, Floats, Floats]
) -> None:
    """Take in the thirds of every window: the bar is that of noise and the largest doubt in the third."""
    (value, noise, doubt), part, count = found, fits.length // fits.parts, len(fits.starts)
    third = fits.parts // 3
    for kind, (start, stop) in enumerate(((0, third), (third, fits.parts - third), (fits.parts - third, fits.parts))):
        largest = doubt[start * part : stop * part].max(axis=0)
        step = part if count > 1 else (stop - start) * part
        for sample in range(start * part, stop * part, step):
            row = int(fits.starts[0]) + sample
            values, bars, places = (each[kind, row : row + step * count] for each in (best.value, best.bar, sources))
            new = (noise[sample : sample + step] + largest).T
            at = np.flatnonzero(new < bars.reshape(count, step))
            if len(at):
                place = sample * count + (at if step == 1 else at % step * count + at // step)
                bar, own = new.ravel().take(at), value.ravel().take(place)
                alike = np.abs(own - values.take(at)) <= bar + bars.take(at)
                if not alike.all():
                    at, own, bar, place = (each[alike] for each in (at, own, bar, place))
                values[at], bars[at], places[at] = own, bar, known + place


def _weighed(best: _Best, slope: Floats, rate: Rate) -> tuple[Floats, Rate]:
    """The mean of all, and of a slope and rate otherwise found, weighed by their bars; where those before and after
    disagree, what lies between."""
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
