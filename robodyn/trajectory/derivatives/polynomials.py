"""Least-squares polynomials about samples and on windows, on any stamps: Savitzky and Golay (1964).

Polynomials that are orthonormal on the samples take the place of equations that would have to be solved.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats
from robodyn.support.sums import einsum
from robodyn.trajectory.motion import NOISE

DEGREE = 6
"""The highest degree that is fitted to a window."""
SIZES = ((6, 1), (7, 1), *((parts, 1 << k) for k in range(8) for parts in (9, 12, 15)))
"""Of the windows of each length: parts, and the samples of a part, by which one begins after the other."""
LOUD = 4.0
"""Times its standard deviation in the table, from which on what a window leaves is no noise."""
SMOOTH = 1.0
"""Ratio of the mean squares of what is left, from sample to sample and as it is; 2 of white noise."""
_CELLS = 1 << 15
_OWN = np.array((1.0, 2.0))
"""How often p_k and its slope count in the slope and the curvature of x p_k."""


class Basis(NamedTuple):
    """Orthonormal polynomials of degree 0 to d: their values on the samples, and value and derivatives elsewhere.

    Attributes:
        on: (d + 1, w, ...); value, slope, curve: (d + 1, ...).
    """

    on: Floats
    value: Floats
    slope: Floats
    curve: Floats


def orthonormal(u: Floats, x: Floats, degree: int) -> Basis:
    """Polynomials that are orthonormal on samples at u, and their derivatives at x.

    By the recurrence `b_k+1 p_k+1 = (u - a_k) p_k - b_k p_k-1` of Stieltjes: the error grows with the condition of the
    fit itself, not with its square.

    Args:
        u: (w, ...), w > degree; x: (...) or any shape that goes with u's beyond the first axis.

    Returns:
        NaN or infinities where fewer than degree + 1 of the samples differ.
    """
    size = 1.0 / np.sqrt(len(u))
    on = np.full((degree + 1, *u.shape), size)
    at = np.zeros((degree + 1, 3, *x.shape))
    at[0, 0], b = size, np.zeros(u.shape[1:])
    for k in range(degree):
        a = _inner(u * on[k], on[k])
        new = (u - a) * on[k]
        here = (x - a) * at[k]
        here[1:] += at[k, :2] * _OWN.reshape(2, *np.ones(x.ndim, dtype=int))
        if k:
            new -= b * on[k - 1]
            here -= b * at[k - 1]
        b = np.sqrt(_inner(new, new))
        np.divide(new, b, out=on[k + 1])
        np.divide(here, b, out=at[k + 1])
    return Basis(on, *at.swapaxes(0, 1))


def _inner(a: Floats, b: Floats) -> Floats:
    """Sums of products over the samples, in an order that the number of samples alone decides."""
    total: Floats = einsum("w...,w...->...", a, b)
    return total


def at_samples(
    time: Floats | None,
    values: Floats,
    turns: Floats | None,
    centres: NDArray[np.intp],
    width: int,
    degree: int,
) -> tuple[Floats, Floats, Floats]:
    """Residual and both derivatives (k, c) at some samples, each by the polynomial of its own window.

    Near an end the window stays inside the table, so the sample is not in its middle. A result depends on the samples
    of its own window alone, to the last bit.

    Args:
        time: (N,) increasing, or None where all samples are a unit apart.
        values: (N, c); turns: (N, c) whole turns of 2 pi that they are ahead by, None for none.
        centres: (k,) rows; width <= N; degree < width.

    Accuracy: 1e-11 of the largest derivative where no gap is shorter than a thousandth of the longest.
    """
    found, columns = np.empty((3, values.shape[1], len(centres))), np.ascontiguousarray(values.T)
    for some in np.array_split(np.arange(len(centres)), -(-len(centres) * width // _CELLS)):
        centre = centres[some]
        start = np.clip(centre - width // 2, 0, len(values) - width)
        rows = start + np.arange(width)[:, None]
        if time is None:
            basis = orthonormal(np.arange(float(width))[:, None], (centre - start).astype(float), degree)
        else:
            basis = orthonormal(time[rows] - time[centre], np.zeros(len(centre)), degree)
        for k, column in enumerate(columns):
            own = column[rows] - column[centre]
            if turns is not None:
                own -= 2.0 * math.pi * (turns[rows, k] - turns[centre, k])
            coefficients = [_inner(on, own) for on in basis.on]
            for out, each in zip(found, basis[1:], strict=True):
                out[k, some] = sum(a * part for a, part in zip(coefficients, each, strict=True))
    return -found[0].T, found[1].T, found[2].T


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
        """(w,) what white noise would have to be to explain what a fit of a degree leaves, sigma or more.

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
    """The windows of one of `SIZES` that begin where a part of the table does.

    Args:
        time: (N,) s, or None for samples a unit apart; values: (N,); turns: (N,) whole turns of 2 pi that they are
            ahead by, None for none; first: of the samples, counted in the table.
    """
    parts, part = size
    return _fitted(time, values, turns, np.arange(-first % part, len(values) + 1 - parts * part, part), size)


def all_windows(time: Floats | None, values: Floats, turns: Floats | None, first: int, sizes: int) -> Iterator[Windows]:
    """Those of all lengths, of the first of `SIZES`, and those which begin or end with the samples; see `windows`."""
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
    coefficients = np.stack([_inner(np.broadcast_to(on, y.shape), y) for on in basis.on])
    return Windows(starts, size[0], basis, coefficients, y, half)


@lru_cache(maxsize=64)
def _even(length: int, degree: int) -> Basis:
    u = (np.arange(length, dtype=np.float64) / (0.5 * (length - 1)) - 1.0)[:, None]
    return orthonormal(u, u, degree)


def coherent(size: float, samples: int) -> float:
    """The white noise whose bar is what an oscillation of this amplitude does to a fit at the worst."""
    return size * math.sqrt(0.5 * samples) / NOISE
