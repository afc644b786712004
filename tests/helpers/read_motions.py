"""Exact motions as tables have them: read by encoders, rounded, late, and with velocities made in several ways."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from helpers.exact_motions import Array, Course, Rng

LATE = 1 / 3
"""Largest delay of a stamp, of the time between samples."""


class Table(NamedTuple):
    """What a table holds, and what its author knows of the encoder.

    Attributes:
        instants: (N,) when the samples were taken [s]. time: (N,) what the table says of it.
        q: (N, n) positions as they were read. qd, qdd: (N, n), or None where the table has none.
        declared: the largest cyclic error of the encoder, where it is declared [rad or m].
    """

    instants: Array
    time: Array
    q: Array
    qd: Array | None
    qdd: Array | None
    declared: float | None = None


READINGS = (
    "exact",
    "six decimals",
    "12 to 14 bits",
    "15 to 17 bits",
    "18 to 22 bits",
    "white noise",
    "correlated noise",
    "jittered stamps",
    "late stamps",
    "cyclic error, declared",
)
GIVEN = ("none", "velocity", "noisy velocity", "both", "both noisy", "both filtered")
"""Rates that a table has: exact, by `numpy.gradient` of the positions, or these behind a filter that lags."""


def steps(rng: Rng, least: int, most: int) -> float:
    """One turn by the steps of an encoder of so many bits [rad]."""
    return float(2 * np.pi / 2.0 ** rng.integers(least, most + 1))


def read(course: Course, rng: Rng, hz: float, reading: str, given: str, units: Array) -> Table:
    """Sample a motion at this rate [Hz]; `units` (n,) are 1 of revolute joints, of others metres by motor's radian."""
    instants = np.arange(0.0, course.duration, 1 / hz)
    if reading == "jittered stamps":
        inner = rng.uniform(-0.3, 0.3, len(instants)) / hz
        instants = np.round(instants + np.maximum(inner, -instants), 6)
    q, qd, qdd = course.at(instants)
    time, declared, step = instants, None, 0.0
    if reading == "six decimals":
        q = np.round(q, 6)
    elif "bits" in reading:
        least, _, most, _ = reading.split()
        step = steps(rng, int(least), int(most))
    elif "stamps" in reading:
        step = steps(rng, 15, 19)
        time = instants + rng.uniform(0.0, LATE / hz, len(instants)) if reading == "late stamps" else instants
    elif reading == "white noise":
        q = q + 10.0 ** rng.uniform(-5.5, -3.5) * units * rng.standard_normal(q.shape)
    elif reading == "correlated noise":
        q = q + 10.0 ** rng.uniform(-5.5, -3.5) * units * correlated(rng, q.shape, rng.uniform(0.5, 0.95))
    elif reading == "cyclic error, declared":
        lines = 2.0 ** float(rng.integers(6, 12))
        declared = rng.uniform(0.001, 0.01) * 2 * np.pi / lines
        q, step = q + units * cyclic(rng, q / units, lines, declared), steps(rng, 17, 22)
    if step:
        q = step * units * np.round(q / (step * units))
    return Table(instants, time, q, *rates(rng, given, time, q, qd, qdd), declared)


def correlated(rng: Rng, shape: tuple[int, ...], kept: float) -> Array:
    """Noise of unit variance, each value `kept` of the one before."""
    from scipy.signal import lfilter

    off = rng.standard_normal((shape[0] + 200, *shape[1:]))
    return lfilter([np.sqrt(1 - kept**2)], [1.0, -kept], off, axis=0)[200:]


def cyclic(rng: Rng, angle: Array, lines: float, size: float) -> Array:
    """Interpolation error of an encoder with so many lines: once and twice each, at most `size` together [rad]."""
    second, (p1, p2) = rng.uniform(0, 0.5), rng.uniform(0, 2 * np.pi, 2)
    return size * ((1 - second) * np.sin(lines * angle + p1) + second * np.sin(2 * lines * angle + p2))


def rates(rng: Rng, given: str, time: Array, q: Array, qd: Array, qdd: Array) -> tuple[Array | None, Array | None]:
    """Columns of velocity and acceleration, made in this way."""
    if given == "none":
        return None, None
    if given == "velocity":
        return qd, None
    if given == "both":
        return qd, qdd
    slope = np.gradient(q, time, axis=0)
    if given == "noisy velocity":
        return slope, None
    if given == "both filtered":
        slope = lagged(slope, time, rng.uniform(10, 50))
    return slope, np.gradient(slope, time, axis=0)


def lagged(values: Array, time: Array, hz: float) -> Array:
    """A filter of first order with this cutoff [Hz], as drives have them."""
    out, kept = values.copy(), np.exp(-2 * np.pi * hz * np.diff(time))
    for k, share in enumerate(kept, 1):
        out[k] = share * out[k - 1] + (1 - share) * values[k]
    return out
