"""Samples of measured torques that are none: far off their neighbours, or clipped; and the steps torques come in."""

from __future__ import annotations

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
