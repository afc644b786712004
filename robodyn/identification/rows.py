"""Samples of a log with derivatives, and what is computed of them, filtered as the measured torques are."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

import numpy as np

from robodyn.identification.filters import convolved, decimation, kernel, rates
from robodyn.identification.log import Log
from robodyn.identification.samples import Samples
from robodyn.support.floats import Floats

POSITIONS = 2.5
"""Positions pass up to so many times the cutoff: what friction makes of a turn is sharper than what is compared."""
_ROWS = 4096
"""Samples that are worked on at a time."""

Arrays = tuple[Floats, ...]


class Rows(NamedTuple):
    """Filtered values, at instants so far apart that none repeats its neighbours.

    Attributes:
        time: (k,) s.
        values: (k, ...) what was computed of the samples.
        tau: (k, n) measured torques [N m].
    """

    time: Floats
    values: Floats
    tau: Floats


def states(log: Log, cutoff: float) -> Iterator[Samples]:
    """Yield the samples of a log with velocities and accelerations, block by block.

    Where positions are noisy, they pass a zero-phase filter of `POSITIONS` times the cutoff, and the derivatives are of
    what passes; the ends of each stretch are lost to it.
    """
    parts = (part for block in log.blocks() for part in _cut(block))
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
    """Yield what `compute` makes of the samples, and the measured torques, both through the same zero-phase filter.

    Args:
        cutoff: Hz, see `filters.kernel`.
        compute: samples -> (k, ...), zero where the torque that it stands beside is left out, as that is here.
    """
    taps, every = kernel(cutoff, log.step), decimation(cutoff, log.step)
    reach = len(taps) // 2
    computed = ((each.begins, (each.time, compute(each), np.nan_to_num(each.tau))) for each in states(log, cutoff))
    for _, (time, values, tau), count in _windows(computed, len(taps), every):
        yield Rows(
            time[reach : len(time) - reach : every][:count],
            convolved(values, taps, every),
            convolved(tau, taps, every),
        )


def _cut(block: Samples) -> Iterator[Samples]:
    for start in range(0, len(block.time), _ROWS):
        yield block.cut(slice(start, start + _ROWS), block.begins and start == 0)


def _windows(parts: Iterable[tuple[bool, Arrays]], length: int, every: int) -> Iterator[tuple[bool, Arrays, int]]:
    """Yield arrays that begin with what the windows of the next values need of the ones before.

    Args:
        parts: whether a stretch begins, and arrays of as many rows.
        length: of a window [rows]; every: rows from one window to the next.

    Yields:
        Whether these are the first windows of a stretch, the arrays, and the number of whole windows.
    """
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
