"""Single samples of measured torques that are far off their neighbours: errors of transmission, not torques."""

from __future__ import annotations

import numpy as np

from robodyn.support.floats import Floats

_WIDTH = 7
"""Samples of the running median: three wrong ones next to each other are seen."""
_DEVIATIONS = 10.0
"""Of what torques are usually off the running median, told by the median of that."""
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


def _medians(tau: Floats) -> Floats:
    half = _WIDTH // 2
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(tau, ((half, half), (0, 0)), mode="edge"), _WIDTH, axis=0)
    return np.asarray(np.median(windows, axis=-1))
