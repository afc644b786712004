"""The zero-phase low-pass filter that acts on both sides, computed and measured, block by block."""

from __future__ import annotations

import math

import numpy as np

from robodyn.support.floats import Floats

SHAPE = 8.0
"""Of Kaiser's window: the pass band is flat within 1e-4, what is stopped keeps 1e-4."""
PERIODS = 5.1
"""Half the length of the kernel in periods of the cutoff: from 0.75 to 1.25 times the cutoff, by Kaiser's rule."""
_TOGETHER = 32
"""So many values are summed by one product of matrices."""


def kernel(cutoff: float, step: float) -> Floats:
    """Return the taps (odd number) of a low-pass filter of even symmetry, hence without phase; they add up to 1.

    Args:
        cutoff: where half of the amplitude passes [Hz], below the Nyquist frequency.
        step: between samples [s].
    """
    half = max(1, round(PERIODS / (cutoff * step)))
    place = np.arange(-half, half + 1)
    window = np.i0(SHAPE * np.sqrt(1.0 - (place / (half + 1)) ** 2))
    taps = window * np.sinc(2.0 * cutoff * step * place)
    return np.asarray(taps / taps.sum())


def rates(taps: Floats, step: float) -> tuple[Floats, Floats, Floats]:
    """Return kernels of one length, for `convolved`, that smooth, and that smooth and differentiate once and twice.

    The differences are central, of fourth order: they are off by (2 pi f step)^4 / 30 and / 90 of the derivative.
    """
    first = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / (12.0 * step)
    second = np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) / (12.0 * step * step)
    return np.pad(taps, 2), np.convolve(taps, first), np.convolve(taps, second)


def convolved(values: Floats, taps: Floats, every: int = 1) -> Floats:
    """Return (k, ...) the values (N, ...) filtered wherever windows are whole: around sample `reach`, and so on.

    Args:
        every: of so many samples one is filtered.
    """
    flat = np.ascontiguousarray(values).reshape(len(values), -1)
    count = max(0, (len(values) - len(taps)) // every + 1)
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
