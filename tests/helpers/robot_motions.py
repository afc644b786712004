"""Joint motions for the example trajectories, with exact derivatives.

All arithmetic is mpmath's, at the precision of the caller: unlike the platform's sine, it gives every machine the
same digits.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

from mpmath import mp, mpf

State = tuple[mpf, mpf, mpf]
Motion = Callable[[mpf], State]


def exact(*values: float | str) -> list[mpf]:
    """The numbers as they are written: 0.1 is one tenth."""
    return [mpf(str(value)) for value in values]


def quintic(*knots: tuple[float, float]) -> Motion:
    """Point to point through (time, position) knots, at rest in each; equal neighbours dwell.

    Between knots q = a + (b - a)(10 s^3 - 15 s^4 + 6 s^5), s the share of the time passed; (q, qd, qdd) is returned.
    """
    points = [exact(*knot) for knot in knots]

    def motion(t: mpf) -> State:
        for (start, a), (end, b) in pairwise(points):
            if t <= end:
                T = end - start
                s = (t - start) / T
                rise = s**3 * (10 + s * (6 * s - 15))
                slope = 30 * (s * (1 - s)) ** 2
                bend = 60 * s * (1 - s) * (1 - 2 * s)
                return a + (b - a) * rise, (b - a) / T * slope, (b - a) / T**2 * bend
        return points[-1][1], mpf(0), mpf(0)

    return motion


def fourier(mean: float, period: float, *terms: tuple[float, float]) -> Motion:
    """mean + sum of a_k sin(2 pi k t / period) + b_k cos(...) over the terms (a_k, b_k), k = 1, 2, ..."""
    centre, T = exact(mean, period)
    waves = [(2 * mp.pi * k / T, *exact(*term)) for k, term in enumerate(terms, 1)]

    def motion(t: mpf) -> State:
        q, qd, qdd = centre, mpf(0), mpf(0)
        for w, a, b in waves:
            s, c = mp.sin(w * t), mp.cos(w * t)
            q += a * s + b * c
            qd += w * (a * c - b * s)
            qdd -= w * w * (a * s + b * c)
        return q, qd, qdd

    return motion
