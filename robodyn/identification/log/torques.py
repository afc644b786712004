"""Measured torques: spikes, clipping, the steps they come in, and the frequency above which they are noise."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats

_WIDTH = 7
"""Samples of the running median: three wrong ones next to each other are seen."""
_DEVIATIONS = 10.0
"""Of what torques are usually off the running median, told by the median of that."""
_OFTEN, _PILED = 8, 5.0
"""Samples at a torque's extreme, and how many times those one and two steps below, from which on it is clipped; the top
of a parabola is reached 2.4 times as often as what is one step below."""
_VALUES = 500
_SHARE = 0.5
"""Of the range of 98 % of the running medians."""


def limits(tau: Floats) -> Floats:
    """Return (n,) how far off the running median a torque is a spike; infinite where none of tau (N, n) is."""
    middle = _medians(tau)
    off = np.abs(tau - middle)
    low, high = np.quantile(middle, (0.01, 0.99), axis=0)
    found = np.maximum(_DEVIATIONS * np.median(off, axis=0) / 0.6745, _SHARE * (high - low))
    return np.asarray(np.where((off > found).any(axis=0) & (found > 0.0), found, np.inf))


def mended(tau: Floats, limit: Floats) -> Floats:
    """Return (N, n) torques with the running median in the place of spikes."""
    if np.isinf(limit).all():
        return tau
    middle = _medians(tau)
    return np.asarray(np.where(np.abs(tau - middle) > limit, middle, tau))


def clipping(tau: Floats, moves: NDArray[np.bool_]) -> Floats:
    """Return (2, n) the least and the largest torque, where it stands there as nothing that moves does; else infinite.

    Args:
        tau: (N, n) N m. moves: (N,) whether any joint does; a robot at rest needs the same torque for long.
    """
    found = np.stack((np.full(tau.shape[1], -np.inf), np.full(tau.shape[1], np.inf)))
    for j, column in enumerate(tau[moves].T):
        values, counts = np.unique(column, return_counts=True)
        for side, order in enumerate((slice(None), slice(None, None, -1))):
            most, next_ones = counts[order][:1].sum(), counts[order][1:3]
            if len(values) > 1 and most >= _OFTEN and most > _PILED * next_ones.max():
                found[side, j] = values[order][0]
    return found


def step_of(tau: Floats) -> float:
    """Return the step that torques (N,) come in; 0 of more than some hundred values."""
    size = float(np.ptp(tau)) or 1.0
    values = np.unique(np.round(tau / size, 9))
    return float(np.diff(values).min()) * size if 1 < len(values) < _VALUES else 0.0


def noise_of(tau: Floats) -> Floats:
    """Return (n,) the standard deviation of white noise, by the median of second differences; 0 of coarse steps."""
    return np.asarray(np.median(np.abs(np.diff(tau, 2, axis=0)), axis=0) / (0.6745 * np.sqrt(6.0)))


def _medians(tau: Floats) -> Floats:
    half = _WIDTH // 2
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(tau, ((half, half), (0, 0)), mode="edge"), _WIDTH, axis=0)
    return np.asarray(np.median(windows, axis=-1))


_LOUD = 10.0
"""Times the noise: torques that are compared."""


def noise_cutoff(tau: Floats, step: float) -> float:
    """Return the frequency [Hz] above which torques are noise, rounded to two digits: the median of the joints.

    The amplitude spectrum (Welch's, Hann window) is above ten times that of the highest octave up to there, by
    medians over sixths of an octave, which see no single lines; and at least 1e-5 of the power is above. It lies
    between 60 periods of the log, of which the filter leaves five sixths, and a fifth of the sampling rate.

    Args:
        tau: (N, k) N m.
    """
    length = max(64, 1 << int(np.log2(max(len(tau) // 4, 1))))
    window = np.hanning(length)[:, None]
    power = np.zeros((length // 2 + 1, tau.shape[1]))
    for start in range(0, max(1, len(tau) - length + 1), length // 2):
        part = tau[start : start + length]
        power += np.abs(np.fft.rfft(window[: len(part)] * (part - part.mean(axis=0)), length, axis=0)) ** 2
    frequency = np.fft.rfftfreq(length, step)
    floor = _LOUD**2 * np.median(power[len(power) // 2 :], axis=0)
    left = np.cumsum(power[::-1], axis=0)[::-1]
    found = np.zeros(tau.shape[1])
    edges = frequency[1] * 2.0 ** np.arange(0.0, np.log2(len(power) - 1), 1.0 / 6.0)
    for low, high in pairwise(edges):
        band = (frequency >= low) & (frequency < high)
        if band.any():
            loud = (np.median(power[band], axis=0) > floor) & (left[np.argmax(band)] > 1e-5 * left[0])
            found[loud] = high
    lowest, highest = 60.0 / (len(tau) * step), 0.2 / step
    return float(f"{min(max(float(np.median(found)), lowest), highest):.2g}")
