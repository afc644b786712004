"""The frequency above which measured torques are noise."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from robodyn.support.floats import Floats

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
