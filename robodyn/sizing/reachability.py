"""The fastest pass along a path: which speeds can be reached, and from which the end can, grid point by grid point.

Source: Pham and Pham, "A new approach to time-optimal path parameterization based on reachability analysis" (2018),
with their interpolation scheme: in each interval the acceleration along the path, u, is constant, x = sd^2 is a
straight line, and `a u + b x <= d` holds at both its ends.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robodyn.support.floats import Floats

_ZERO = 1e-11  # of a row's largest coefficient of u: what is less does not limit u
_SLACK = 1e-11  # of the limits of u, by which rounding may cross them
_TRIES = 100


class Rows(NamedTuple):
    """`a u + b x <= d`, each (2, N, R): at the beginning and at the end of N intervals."""

    a: Floats
    b: Floats
    d: Floats


class Intervals:
    """The rows of intervals as limits of u that fall or rise with the x at their beginning: `u <= p - q x` (and
    `-u <= p - q x`), and the limits of x alone."""

    def __init__(self, rows: Rows, steps: Floats, most: Floats) -> None:
        """Args: steps: (N,) lengths of the intervals; most: (N + 1,) of x."""
        a = np.concatenate((rows.a[0], rows.a[1] + 2.0 * steps[:, None] * rows.b[1]), axis=1)
        b, d = np.concatenate((rows.b[0], rows.b[1]), axis=1), np.concatenate((rows.d[0], rows.d[1]), axis=1)
        self.steps, n = steps, len(steps)
        small = _ZERO * np.abs(a).max(axis=0, initial=0.0)
        up, down = a > small, a < -small
        idle = ~(up | down)
        with np.errstate(all="ignore"):
            p, q, bound = d / a, b / a, d / b
        self.p = np.stack((np.where(up, p, np.inf), np.where(down, -p, np.inf)), axis=1)
        self.q = np.stack((np.where(up, q, 0.0), np.where(down, -q, 0.0)), axis=1)
        if not a.shape[1]:
            self.p, self.q = np.full((n, 2, 1), np.inf), np.zeros((n, 2, 1))
        weight = 1e-13 * (np.abs(d) + np.abs(b)).max(axis=0, initial=0.0)
        high = np.where(idle & (b > weight), bound, np.inf).min(axis=1, initial=np.inf)
        low = np.where(idle & (b < -weight), bound, 0.0).max(axis=1, initial=0.0)
        low = np.where((idle & (np.abs(b) <= weight) & (d < 0.0)).any(axis=1), np.inf, low)
        self.high, self.low = np.minimum(high, most[:-1]), low

    def fastest(self) -> tuple[Floats, int | None]:
        """Return x (N + 1,) of the fastest pass that is at rest at both ends: the sets of x from which the end can be
        reached, backwards, then the largest step into each, forwards; and the interval that stops it, if one does."""
        n, steps = len(self.steps), self.steps.tolist()
        x, highs, lows = np.zeros(n + 1), [0.0] * (n + 1), [0.0] * (n + 1)
        tops, bottoms = self.high.tolist(), self.low.tolist()
        free = (self.p.min(axis=2) >= 0.0).all(axis=1).tolist()
        p, q = list(self.p), list(self.q)
        top = bottom = 0.0
        for k in range(n - 1, -1, -1):
            half, after, least = 0.5 / steps[k], top, bottom
            top = _root(p[k], q[k], tops[k], after, least, half, 1.0)
            if not free[k] or least > 0.0 or bottoms[k] > 0.0:
                bottom = _root(p[k], q[k], bottoms[k], after, least, half, -1.0)
            if not bottom <= top:
                return x, k
            highs[k], lows[k] = top, bottom
        if bottom > 0.0:
            return x, 0
        now = 0.0
        for k in range(n):
            values = p[k] - q[k] * now
            i, j = values.argmin(axis=1).tolist()
            up, down = float(values[0, i]), -float(values[1, j])
            step = 2.0 * steps[k]
            after = now + step * max(min(up, (highs[k + 1] - now) / step), down)
            after = min(max(after, lows[k + 1]), highs[k + 1])
            x[k + 1] = now = after
            if now == 0.0 and x[k] == 0.0:
                return x, k
        return x, None


def _root(p: Floats, q: Floats, x: float, after: float, least: float, half: float, side: float) -> float:
    """Return the largest (side 1) or the least (-1) x within an interval's limits from which an x of the next, from
    `least` to `after`, is reached: where the largest u and the least meet, by Newton's steps from outside."""
    x = min(x, 1e12)
    for _ in range(_TRIES):
        values = p - q * x
        i, j = values.argmin(axis=1).tolist()
        up, down = float(values[0, i]), float(values[1, j])
        level, falls = float(p[0, i]), float(q[0, i])
        if (reach := (after - x) * half) < up:
            up, level, falls = reach, after * half, half
        if (reach := (x - least) * half) < down:
            down, level, falls = reach, level - least * half, falls - half
        else:
            level, falls = level + float(p[1, j]), falls + float(q[1, j])
        if up + down >= -_SLACK * (abs(up) + abs(down)):
            return x
        if falls * side <= 0.0:
            break
        x, last = level / falls, x
        if abs(x - last) <= _SLACK * abs(x):
            return x
    return -1.0 if side > 0.0 else float("inf")
