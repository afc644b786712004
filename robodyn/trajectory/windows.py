"""Least-squares polynomials on windows of samples, short and long, which overlap by most of their length."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats
from robodyn.support.sums import einsum
from robodyn.trajectory.local_polynomials import Basis, orthonormal
from robodyn.trajectory.motion import NOISE

DEGREE = 6
"""The highest degree that is fitted."""
SIZES = ((6, 1), (7, 1), *((parts, 1 << k) for k in range(8) for parts in (9, 12, 15)))
"""Of the windows of each length: parts, and the samples of a part, by which one begins after the other."""


LOUD = 4.0
"""Times its standard deviation in the table, from which on what a window leaves is no noise."""

SMOOTH = 1.0
"""Ratio of the mean squares of what is left, from sample to sample and as it is; 2 of white noise."""


def coherent(size: float, samples: int) -> float:
    """Return the white noise whose bar is what an oscillation of this amplitude does to a fit at the worst."""
    return size * math.sqrt(0.5 * samples) / NOISE


@dataclass(frozen=True)
class Windows:
    """The fits to all windows of a length, w of them with n samples each.

    Attributes:
        starts: (w,) first samples; parts: of how many equal parts a window is, each from which another begins.
        basis: polynomials of degree 0 to d, orthonormal on the samples: (d + 1, n, w), or (d + 1, n, 1) for all.
        coefficients: (d + 1, w) of the fit, each with the standard deviation of white noise.
        values: (n, w) about their mean.
        half: of the duration [s], (w,) or a number: what a unit of the basis is.
    """

    starts: NDArray[np.intp]
    parts: int
    basis: Basis
    coefficients: Floats
    values: Floats
    half: Floats | float

    @property
    def length(self) -> int:
        return int(self.basis.on.shape[1])

    def scatter(self, degree: int, sigma: float, noisy: bool) -> Floats:
        """Return (w,) what white noise would have to be to explain what a fit of a degree leaves, sigma or more.

        It is told by sums over parts, since what a fit misses of the motion has one sign for a while, as noise has that
        is correlated. In noisy data what is left that is much larger than noise, and smooth, is a vibration that the
        fit misses, whose accelerations it says nothing of: infinity.
        """
        rest = self.values.copy()
        for on, coefficients in zip(self.basis.on[: degree + 1], self.coefficients, strict=False):
            rest -= on * coefficients
        parts = min(self.parts, 15)
        part = self.length // parts
        sums = rest[: parts * part].reshape(parts, part, -1).sum(axis=1)
        found = np.sqrt((sums**2).sum(axis=0) / (part * max(1, parts - degree - 1)))
        found = np.maximum(found, sigma)
        if noisy:
            left, rough = ((each**2).mean(axis=0) for each in (rest, np.diff(rest, axis=0)))
            found[(left > (LOUD * sigma) ** 2) & (rough < SMOOTH * left)] = np.inf
        return np.asarray(found)


def windows(time: Floats | None, values: Floats, turns: Floats | None, size: tuple[int, int], first: int) -> Windows:
    """Return the windows of one of `SIZES` that begin where a part of the table does.

    Args:
        time: (N,) s, or None for samples a unit apart; values: (N,); turns: (N,) whole turns of 2 pi that they are
            ahead by, None for none; first: of the samples, counted in the table.
    """
    parts, part = size
    return _fitted(time, values, turns, np.arange(-first % part, len(values) + 1 - parts * part, part), size)


def all_windows(time: Floats | None, values: Floats, turns: Floats | None, first: int, sizes: int) -> Iterator[Windows]:
    """Yield those of all lengths, and those which begin or end with the samples.

    Args:
        sizes: how many of `SIZES`; other arguments as of `windows`.
    """
    for parts, part in SIZES[:sizes]:
        length, last = parts * part, len(values) - parts * part
        if last < 0:
            return
        found = windows(time, values, turns, (parts, part), first)
        if len(found.starts):
            yield found
        for end in {0, last} - {*found.starts[:1].tolist(), *found.starts[-1:].tolist()}:
            yield _fitted(time, values, turns, np.array([end]), (length, 1))


def _fitted(
    time: Floats | None, values: Floats, turns: Floats | None, starts: NDArray[np.intp], size: tuple[int, int]
) -> Windows:
    length = size[0] * size[1]
    rows = starts + np.arange(length)[:, None]
    y = values[rows] - values[starts]
    if turns is not None:
        y -= 2.0 * math.pi * (turns[rows] - turns[starts])
    y -= y.mean(axis=0)
    degree = min(DEGREE, length - 2)
    half: Floats | float
    if time is None:
        half, basis = 0.5 * (length - 1), _even(length, degree)
    else:
        t = time[rows]
        half = 0.5 * (t[-1] - t[0])
        u = (t - 0.5 * (t[-1] + t[0])) / half
        basis = orthonormal(u, u, degree)
    coefficients = np.stack([einsum("nw,nw->w", np.broadcast_to(on, y.shape), y) for on in basis.on])
    return Windows(starts, size[0], basis, coefficients, y, half)


@lru_cache(maxsize=64)
def _even(length: int, degree: int) -> Basis:
    u = (np.arange(length, dtype=np.float64) / (0.5 * (length - 1)) - 1.0)[:, None]
    return orthonormal(u, u, degree)
