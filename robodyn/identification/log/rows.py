"""Samples of a log and what is computed of them, through the zero-phase filter that the measured torques pass."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

import numpy as np

from robodyn.identification.log.log import Log, Samples
from robodyn.support.floats import Floats

POSITIONS = 2.5
"""Positions pass up to so many times the cutoff: what friction makes of a turn is sharper than what is compared."""
_ROWS = 4096  # samples that are worked on at a time

Arrays = tuple[Floats, ...]
SHAPE, PERIODS = 8.0, 5.1
"""Of Kaiser's window, by which the pass band is flat within 1e-4 and what is stopped keeps 1e-4; half the length of the
kernel in periods of the cutoff, which takes it from 0.75 to 1.25 times the cutoff (Kaiser's rule)."""
_TOGETHER = 32  # so many values are summed by one product of matrices


class Rows(NamedTuple):
    """Filtered values (k, ...) and torques (k, n) [N m], at times so far apart that none repeats its neighbours."""

    time: Floats
    values: Floats
    tau: Floats


def states(log: Log, cutoff: float) -> Iterator[Samples]:
    """Yield the samples of a log with velocities and accelerations, block by block. Noisy positions pass a zero-phase
    filter of `POSITIONS` times the cutoff before they are derived; the ends of each stretch are lost to it."""
    parts = (
        block.cut(slice(start, start + _ROWS), block.begins and start == 0)
        for block in log.blocks()
        for start in range(0, len(block.time), _ROWS)
    )
    if not log.noisy:
        yield from parts
        return
    kernels = rates(kernel(min(POSITIONS * cutoff, 0.4 / log.step), log.step), log.step)
    reach = len(kernels[0]) // 2
    begun = ((part.begins, (part.time, part.q, part.tau)) for part in parts)
    for begins, (time, q, tau), _ in _windows(begun, len(kernels[0]), 1):
        inner = slice(reach, len(time) - reach)
        smooth, first, second = (convolved(q, taps) for taps in kernels)
        yield Samples(time[inner], smooth, first, second, tau[inner], begins)


def filtered(log: Log, cutoff: float, compute: Callable[[Samples], Floats]) -> Iterator[Rows]:
    """Yield what `compute` makes of the samples, and the measured torques, both through the same zero-phase filter;
    compute: samples -> (k, ...), zero where the torque that it stands beside is left out, as that is here."""
    taps, every = kernel(cutoff, log.step), decimation(cutoff, log.step)
    reach = len(taps) // 2
    computed = ((each.begins, (each.time, compute(each), np.nan_to_num(each.tau))) for each in states(log, cutoff))
    for _, (time, values, tau), count in _windows(computed, len(taps), every):
        inner = time[reach : len(time) - reach : every][:count]
        yield Rows(inner, convolved(values, taps, every), convolved(tau, taps, every))


def _windows(parts: Iterable[tuple[bool, Arrays]], length: int, every: int) -> Iterator[tuple[bool, Arrays, int]]:
    """Yield arrays that begin with what windows of so many rows, one `every` so many, need of the ones before: whether
    these are the first windows of a stretch, the arrays, and the number of whole windows."""
    tail: Arrays | None = None
    first = True
    for begins, arrays in parts:
        if begins:
            tail, first = None, True
        whole = arrays if tail is None else tuple(np.concatenate(pair) for pair in zip(tail, arrays, strict=True))
        count = max(0, (len(whole[0]) - length) // every + 1)
        if count:
            yield first, whole, count
            first = False
        tail = tuple(each[count * every :] for each in whole)


def kernel(cutoff: float, step: float) -> Floats:
    """Return the taps (odd number) of a low-pass filter without phase, of which half of the amplitude passes at the
    cutoff [Hz], for samples a step apart [s]; they add up to 1."""
    half = max(1, round(PERIODS / (cutoff * step)))
    place = np.arange(-half, half + 1)
    window = np.i0(SHAPE * np.sqrt(1.0 - (place / (half + 1)) ** 2))
    taps = window * np.sinc(2.0 * cutoff * step * place)
    return np.asarray(taps / taps.sum())


def rates(taps: Floats, step: float) -> tuple[Floats, Floats, Floats]:
    """Return kernels of one length, for `convolved`, that smooth, and that smooth and differentiate once and twice. The
    differences are central, of fourth order: they are off by (2 pi f step)^4 / 30 and / 90 of the derivative."""
    first = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / (12.0 * step)
    second = np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) / (12.0 * step * step)
    return np.pad(taps, 2), np.convolve(taps, first), np.convolve(taps, second)


def convolved(values: Floats, taps: Floats, every: int = 1) -> Floats:
    """Return (k, ...) one of `every` of the values (N, ...), filtered, from the first whose window is whole on."""
    if len(values) < len(taps):
        return np.zeros((0, *values.shape[1:]))
    flat = np.ascontiguousarray(values).reshape(len(values), -1)
    count = (len(values) - len(taps)) // every + 1
    found = np.empty((count, flat.shape[1]))
    width = len(taps) + (_TOGETHER - 1) * every
    together = np.zeros((_TOGETHER, width))
    for i in range(_TOGETHER):
        together[i, i * every : i * every + len(taps)] = taps
    for first in range(0, count, _TOGETHER):
        rows = flat[first * every : first * every + width]
        some = min(_TOGETHER, count - first)
        found[first : first + some] = together[:some, : len(rows)] @ rows
    return found.reshape(count, *values.shape[1:])


def decimation(cutoff: float, step: float) -> int:
    """Return of how many samples one tells all that a filter passes: at 2.5 times the cutoff or more often."""
    return max(1, math.floor(0.4 / (cutoff * step)))
