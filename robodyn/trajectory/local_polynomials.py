"""Derivatives by least-squares polynomials through the samples about each: Savitzky and Golay (1964), on any stamps.

Polynomials that are orthonormal on the samples take the place of equations that would have to be solved, and sums are
taken in an order that never changes: BLAS and LAPACK add in one that depends on the processor, on their threads and on
where arrays lie in memory.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

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
    """Return the polynomials that are orthonormal on samples at u, and their derivatives at x.

    By the recurrence `b_k+1 p_k+1 = (u - a_k) p_k - b_k p_k-1` of Stieltjes: no equations are solved, and the error
    grows with the condition of the fit itself, not with its square.

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
    """Sums of products over the samples, in an order that the shape alone decides."""
    total: Floats = einsum("w...,w...->...", a, b)
    return total


@lru_cache(maxsize=64)
def stencil(width: int, degree: int) -> Basis:
    """The polynomials on `width` samples a unit apart, with derivatives at each."""
    u = np.arange(width, dtype=np.float64) - (width - 1) / 2
    return orthonormal(u, u, degree)


def equally_spaced(steps: Floats, width: int, degree: int) -> tuple[Floats, Floats]:
    """Return the first and second derivatives (N, c) of samples a unit apart.

    Near an end the window stays inside the table, so the sample is not in its middle.

    Args:
        steps: (N - 1, c) from each value to the next; width: odd, <= N; degree: 2 or more, < width.

    Accuracy: 1e-14 of the largest derivative.
    """
    half, count = width // 2, len(steps) + 1
    found = np.empty((2, steps.shape[1], count))
    for k, column in enumerate(np.ascontiguousarray(steps.T)):
        found[:, k, half : count - half] = _by_pairs(column, width, degree)
        found[:, k, :half] = _at_end(column[: width - 1], width, degree)[:, :half]
        found[:, k, count - half :] = _at_end(column[count - width :], width, degree)[:, half + 1 :]
    return found[0].T, found[1].T


def _at_end(steps: Floats, width: int, degree: int) -> Floats:
    """Derivatives (2, width) of the polynomial through the first or last samples of a column, at each of them."""
    basis = stencil(width, degree)
    parts = (basis.on[:, 1:] * np.cumsum(steps)).sum(axis=1)[:, None]
    return np.stack(((basis.slope * parts).sum(axis=0), (basis.curve * parts).sum(axis=0)))


def weights(width: int, degree: int) -> tuple[Floats, Floats]:
    """Weights (width,) of the samples in the first and second derivative at the middle."""
    basis = stencil(width, degree)
    middle = slice(width // 2, width // 2 + 1)
    return (basis.on * basis.slope[:, middle]).sum(axis=0), (basis.on * basis.curve[:, middle]).sum(axis=0)


def _by_pairs(steps: Floats, width: int, degree: int) -> tuple[Floats, Floats]:
    """Derivatives at all samples but those near the ends: of steps as far before as after, sums and differences."""
    first, second = (-np.cumsum(each) for each in weights(width, degree))
    inner = len(steps) + 2 - width
    found, part = np.zeros((2, inner)), np.empty(inner)
    for k in range(width // 2):
        before, after = steps[k : k + inner], steps[width - 2 - k : width - 2 - k + inner]
        found[0] += np.multiply(np.add(before, after, out=part), first[k], out=part)
        found[1] += np.multiply(np.subtract(before, after, out=part), second[k], out=part)
    return found[0], found[1]


def at_samples(
    time: Floats | None,
    values: Floats,
    turns: Floats | None,
    centres: NDArray[np.intp],
    width: int,
    degree: int,
) -> tuple[Floats, Floats, Floats]:
    """Return what is left of some samples, and both derivatives, each (k, c): the polynomial of every window by itself.

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
            shares = [_inner(on, own) for on in basis.on]
            for out, each in zip(found, basis[1:], strict=True):
                out[k, some] = sum(share * part for share, part in zip(shares, each, strict=True))
    return -found[0].T, found[1].T, found[2].T
