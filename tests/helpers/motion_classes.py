"""Motions as robots make them, with the noise of tables: in two halves, one to tune on, one to judge by."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rates = tuple[Array, Array, Array]
Motion = Callable[[np.random.Generator, Array], Rates]


def pieces(t: Array, parts: Sequence[tuple[float, tuple[float, ...]]]) -> Rates:
    """q, qd and qdd of accelerations that are polynomials of time for a while each: (duration, coefficients)."""
    q, qd, qdd = np.empty_like(t), np.empty_like(t), np.empty_like(t)
    start = place = speed = 0.0
    for k, (duration, coefficients) in enumerate(parts):
        a = np.polynomial.Polynomial(coefficients)
        v = a.integ(1, k=speed)
        x = v.integ(1, k=place)
        own = (t >= start) & ((t < start + duration) | (k == len(parts) - 1))
        q[own], qd[own], qdd[own] = x(t[own] - start), v(t[own] - start), a(t[own] - start)
        place, speed, start = float(x(duration)), float(v(duration)), start + duration
    return q, qd, qdd


def trapezoids(rng: np.random.Generator, t: Array) -> Rates:
    """Speeds that are trapezoids: accelerations jump."""
    parts: list[tuple[float, tuple[float, ...]]] = []
    sign = 1.0
    while sum(duration for duration, _ in parts) <= t[-1]:
        a, ramp, cruise = rng.uniform(2, 20) * sign, rng.uniform(0.06, 0.3), rng.uniform(0, 0.3)
        rest = rng.uniform(0, 0.3) * (rng.random() < 0.7)
        parts += [(ramp, (a,)), (cruise, (0.0,)), (ramp, (-a,)), (rest + 1e-9, (0.0,))]
        sign = -sign if rng.random() < 0.8 else sign
    return pieces(t, parts)


def s_curves(rng: np.random.Generator, t: Array) -> Rates:
    """Accelerations that are trapezoids: their rates jump."""
    parts: list[tuple[float, tuple[float, ...]]] = []
    sign = 1.0
    while sum(duration for duration, _ in parts) <= t[-1]:
        a, rise, hold = rng.uniform(2, 20) * sign, rng.uniform(0.03, 0.12), rng.uniform(0, 0.2)
        cruise, rest, jerk = rng.uniform(0, 0.3), rng.uniform(0, 0.3) * (rng.random() < 0.7), a / rise
        for way in (1.0, -1.0):
            up, down = (0.0, way * jerk), (way * a, -way * jerk)
            parts += [(rise, up), (hold, (way * a,)), (rise, down), (cruise if way > 0 else rest + 1e-9, (0.0,))]
        sign = -sign
    return pieces(t, parts)


def sines(rng: np.random.Generator, t: Array) -> Rates:
    """Three sines up to 1.5 Hz."""
    A, w, p = (rng.uniform(low, high, (3, 1)) for low, high in ((0.1, 0.5), (1.2, 9.4), (0.0, 6.28)))
    angle = w * t + p
    return (A * np.sin(angle)).sum(axis=0), (A * w * np.cos(angle)).sum(axis=0), -(A * w**2 * np.sin(angle)).sum(axis=0)


def moves(rng: np.random.Generator, t: Array, shape: Callable[[Array], Rates]) -> Rates:
    """Moves of one shape from 0 to 1 in unit time, with rests between."""
    q, qd, qdd = np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)
    start, place = rng.uniform(0, 0.2), 0.0
    while start < t[-1]:
        duration, far, rest = rng.uniform(0.25, 0.8), rng.uniform(0.2, 1.0) * rng.choice([-1, 1]), rng.uniform(0, 0.3)
        own = (t >= start) & (t < start + duration)
        s, v, a = shape((t[own] - start) / duration)
        q[own], qd[own], qdd[own] = place + far * s, far * v / duration, far * a / duration**2
        place, start = place + far, start + duration
        q[t >= start] = place
        start += rest
    return q, qd, qdd


def minimum_jerk(rng: np.random.Generator, t: Array) -> Rates:
    """Quintics with rests between: the rate of the acceleration jumps."""
    return moves(
        rng,
        t,
        lambda s: (
            10 * s**3 - 15 * s**4 + 6 * s**5,
            30 * s**2 - 60 * s**3 + 30 * s**4,
            60 * s - 180 * s**2 + 120 * s**3,
        ),
    )


def cosine_ramps(rng: np.random.Generator, t: Array) -> Rates:
    """Half a cosine: the acceleration is largest where it jumps."""
    return moves(
        rng, t, lambda s: ((1 - np.cos(np.pi * s)) / 2, np.pi * np.sin(np.pi * s) / 2, np.pi**2 * np.cos(np.pi * s) / 2)
    )


def cycloids(rng: np.random.Generator, t: Array) -> Rates:
    """Sines of acceleration, a period each."""
    w = 2 * np.pi
    return moves(rng, t, lambda s: (s - np.sin(w * s) / w, 1 - np.cos(w * s), w * np.sin(w * s)))


def bang_bang(rng: np.random.Generator, t: Array) -> Rates:
    """As fast as a motor can: full acceleration, then full braking."""
    return moves(
        rng,
        t,
        lambda s: (
            np.where(s < 0.5, 2 * s**2, 1 - 2 * (1 - s) ** 2),
            np.where(s < 0.5, 4 * s, 4 * (1 - s)),
            np.where(s < 0.5, 4.0, -4.0),
        ),
    )


def chirps(rng: np.random.Generator, t: Array) -> Rates:
    """A sine that becomes faster, up to 4 Hz."""
    low, high, A = rng.uniform(0.2, 1.0), rng.uniform(1.0, 4.0), rng.uniform(0.1, 0.5)
    k = 2 * np.pi * (high - low) / t[-1]
    phase, w = 2 * np.pi * low * t + k * t**2 / 2, 2 * np.pi * low + k * t
    return A * np.sin(phase), A * w * np.cos(phase), -A * w**2 * np.sin(phase) + A * k * np.cos(phase)


TUNED: dict[str, Motion] = {"trapezoids": trapezoids, "S-curves": s_curves, "sines": sines}
JUDGED: dict[str, Motion] = {
    "minimum jerk, rests": minimum_jerk,
    "cosine ramps": cosine_ramps,
    "cycloids": cycloids,
    "bang-bang": bang_bang,
    "chirps": chirps,
}
NOISES = ("white", "encoder", "coloured", "late stamps", "none")


def table(motion: Motion, noise: str, rate: float, seed: int, duration: float = 2.0) -> tuple[Array, Array, Rates]:
    """Time and position as a table has them, and the truth at these rows.

    Noise of 3e-6 to 5e-4 rad: white, of an encoder, coloured (each value 0.8 of the one before), or of an encoder whose
    samples are late by up to a third of the time between them.
    """
    rng = np.random.default_rng(seed)
    stamps = np.arange(0.0, duration, 1.0 / rate)
    late = rng.uniform(0.0, 1.0 / 3.0 / rate, len(stamps)) if noise == "late stamps" else 0.0
    true = motion(rng, stamps + late)
    size = 10.0 ** rng.uniform(-5.5, -3.3)
    if noise == "none":
        return stamps, true[0], true
    if noise in ("encoder", "late stamps"):
        return stamps, size * np.round(true[0] / size), true
    off = rng.standard_normal(len(stamps) + 100)
    if noise == "coloured":
        for k in range(1, len(off)):
            off[k] = 0.8 * off[k - 1] + 0.6 * off[k]
    return stamps, true[0] + size * off[100:], true
