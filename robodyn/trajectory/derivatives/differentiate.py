"""First and second derivatives of sampled signals by one method: spline, Savitzky-Golay or central differences.

Fits are by polynomials that are orthonormal on the samples, at any stamps (Savitzky and Golay 1964). Where these are
equally spaced every method is a filter, a matrix whose middle row serves all samples but those near an end.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from robodyn.support.floats import Floats, einsum

DEGREE = 6  # the highest degree that is fitted to a window
SIZES = ((6, 1), (7, 1), *((parts, 1 << k) for k in range(8) for parts in (9, 12, 15)))
"""Of the windows of each length: parts, and the samples of a part, by which one begins after the other."""
LOUD = 4.0  # times its standard deviation in the table, from which on what a window leaves is no noise
SMOOTH = 1.0  # ratio of the mean squares of what is left, from sample to sample and as it is; 2 of white noise
_CELLS = 1 << 15
_OWN = np.array((1.0, 2.0))  # how often p_k and its slope count in the slope and the curvature of x p_k
ORDER = 4
FEWEST = 7  # samples of a spline; through fewer goes one polynomial
REACH = 64  # samples over which a quintic spline forgets: its influence falls by 0.4306 a sample, to 4e-24 here


class Basis(NamedTuple):
    """Orthonormal polynomials of degree 0 to d: on the samples (d + 1, w, ...), value and derivatives elsewhere."""

    on: Floats
    value: Floats
    slope: Floats
    curve: Floats


def orthonormal(u: Floats, x: Floats, degree: int) -> Basis:
    """Polynomials that are orthonormal on samples at u (w, ...), w > degree, and their derivatives at x (...). By the
    recurrence `b_k+1 p_k+1 = (u - a_k) p_k - b_k p_k-1` of Stieltjes: the error grows with the condition of the fit
    itself, not with its square. NaN or infinities where fewer than degree + 1 of the samples differ."""
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
    return np.asarray(einsum("w...,w...->...", a, b))


def at_samples(
    time: Floats | None, values: Floats, turns: Floats | None, centres: NDArray[np.intp], width: int, degree: int
) -> tuple[Floats, Floats, Floats]:
    """Residual and both derivatives (k, c) at rows `centres` (k,) of values (N, c), each by the polynomial of its own
    window alone, inside the table; without time all are a unit apart. Accuracy: 1e-11 of the largest derivative where
    no gap is shorter than a thousandth of the longest."""
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
        starts: (w,) first samples; parts: of a window, at each of which another begins.
        basis: orthonormal on the samples: (d + 1, n, w), or (d + 1, n, 1) for all.
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

    def scatters(self, lowest: int, sigma: float, noisy: bool) -> Iterator[Floats]:
        """(w,) what white noise would have to be to explain what a fit leaves, sigma or more, of fits from the lowest
        degree on: by sums over parts, since what a fit misses keeps its sign as correlated noise does. Where noisy data
        leave what is smooth and much larger than noise, the fit misses a vibration: infinity."""
        rest = self.values.copy()
        parts = min(self.parts, 15)
        part = self.length // parts
        for degree, (on, coefficients) in enumerate(zip(self.basis.on, self.coefficients, strict=True)):
            rest -= on * coefficients
            if degree < lowest:
                continue
            sums = rest[: parts * part].reshape(parts, part, -1).sum(axis=1) if part > 1 else rest[:parts]
            found = np.sqrt((sums**2).sum(axis=0) / (part * max(1, parts - degree - 1)))
            found = np.maximum(found, sigma)
            if noisy:
                left, rough = ((each**2).mean(axis=0) for each in (rest, np.diff(rest, axis=0)))
                found[(left > (LOUD * sigma) ** 2) & (rough < SMOOTH * left)] = np.inf
            yield found


def windows(time: Floats | None, values: Floats, turns: Floats | None, size: tuple[int, int], first: int) -> Windows:
    """The windows of one of `SIZES` that begin where parts of the table do, in which samples begin at row `first`."""
    return _fitted(time, values, turns, slice(-first % size[1], None, size[1]), size)


def all_windows(
    time: Floats | None, values: Floats, turns: Floats | None, first: int, sizes: int, ends: tuple[bool, bool]
) -> Iterator[Windows]:
    """Those of the first of `SIZES`, and those which begin or end with the samples where that is asked for."""
    for parts, part in SIZES[:sizes]:
        length, last = parts * part, len(values) - parts * part
        if last < 0:
            return
        found = windows(time, values, turns, (parts, part), first)
        if len(found.starts):
            yield found
        for end in {0, last} - {*found.starts[:1].tolist(), *found.starts[-1:].tolist()}:
            if ends[end > 0]:
                yield _fitted(time, values, turns, slice(end, end + 1), (length, 1))


def _fitted(time: Floats | None, values: Floats, turns: Floats | None, chosen: slice, size: tuple[int, int]) -> Windows:
    length = size[0] * size[1]
    y = _cut(values, length, chosen)
    y -= y[0].copy()
    if turns is not None:
        turned = _cut(turns, length, chosen)
        y -= 2.0 * math.pi * (turned - turned[0])
    y -= y.mean(axis=0)
    degree = min(DEGREE, length - 2)
    half: Floats | float
    if time is None:
        half, basis = 0.5 * (length - 1), _even(length, degree)
    else:
        t = _cut(time, length, chosen)
        half = 0.5 * (t[-1] - t[0])
        u = (t - 0.5 * (t[-1] + t[0])) / half
        basis = orthonormal(u, u, degree)
    coefficients = np.stack([_inner(np.broadcast_to(on, y.shape), y) for on in basis.on])
    return Windows(np.arange(len(values) + 1 - length)[chosen], size[0], basis, coefficients, y, half)


def _cut(values: Floats, length: int, chosen: slice) -> Floats:
    """(length, w) a copy in which windows are neighbours, as sums depend on that in their last bits."""
    return np.array(sliding_window_view(values, length)[chosen].T, order="C")


@lru_cache(maxsize=64)
def _even(length: int, degree: int) -> Basis:
    u = (np.arange(length, dtype=np.float64) / (0.5 * (length - 1)) - 1.0)[:, None]
    return orthonormal(u, u, degree)


@dataclass(frozen=True)
class Method:
    """A way to differentiate: "spline" (interpolating quintic, `window` 0), "savgol" (least-squares polynomial of an
    `order` over `window` samples), "central" (parabola through three samples) or "local" (`derive`, up to `window`)."""

    kind: Literal["spline", "savgol", "central", "local"]
    window: int = 0
    order: int = 5

    @property
    def text(self) -> str:
        if self.kind == "savgol":
            return f"Savitzky-Golay (window {self.window}, order {self.order})"
        if self.kind == "local":
            return f"local polynomials (windows up to {self.window})"
        return "quintic spline" if self.kind == "spline" else "central differences"

    @property
    def halo(self) -> int:
        """Neighbours on either side of a block that make its derivatives those of the whole table."""
        return REACH if self.kind == "spline" else 2 * self.window

    @property
    def gains(self) -> Floats:
        """(2, w) standard deviation of both derivatives per standard deviation of white noise, of w samples a unit
        apart: first at an end, then in the middle."""
        width = self.window or 2 * REACH + 1
        gains: Floats = np.sqrt((_filter(self.kind == "spline", width, self.order) ** 2).sum(axis=2))
        return gains[:, : width // 2 + 1]


SPLINE = Method("spline")
CENTRAL = Method("central", 3, 2)


def savgol(window: int) -> Method:
    """Savitzky-Golay with quartic polynomials."""
    return Method("savgol", window, ORDER)


def differentiate(time: Floats, values: Floats, method: Method, turns: Floats | None = None) -> tuple[Floats, Floats]:
    """(d/dt, d^2/dt^2) of values at their own times, (N, c); NaN where stamps are so uneven that nothing can be told.

    Equal spacing (to rounding) counts as exactly equal. Fewer samples than the method requires: the polynomial through,
    or fitted to, them all.

    Args:
        time: (N,) s, increasing, N >= 2 (N >= 3 for a second derivative that is not 0).
        values: (N, c); turns: (N, c) whole turns of 2 pi that they are ahead by, None for none.

    Accuracy: the spline's second derivative of sin(2 pi t) at 10 ms: 9e-7 (h^4 / 720 times the sixth derivative), and
    6e-5 at the ends.
    """
    count, spacing = len(time), equal_spacing(time)
    spline = method.kind == "spline" and count >= FEWEST
    width = min(count, 2 * REACH + 1 if spline else method.window or FEWEST - 1)
    degree = min(method.order, width - 1)
    if spacing:
        first, second = _filtered(np.diff(values, axis=0), turns, _filter(spline, width, degree))
        return first / spacing, second / spacing / spacing
    if not spline:
        return at_samples(time, values, turns, np.arange(count), width, degree)[1:]
    from scipy.interpolate import make_interp_spline

    steps, gaps = np.diff(values, axis=0), np.diff(time)[:, None]
    if turns is not None:
        steps -= 2.0 * math.pi * np.diff(turns, axis=0)
    mean = steps.sum(axis=0) / (time[-1] - time[0])  # without it nothing is lost where a joint turns for long
    moved = np.cumsum(np.pad(steps - mean * gaps, ((1, 0), (0, 0))), axis=0)
    try:
        curve = make_interp_spline(time, moved, k=5)  # not-a-knot at both ends: de Boor (1978), ch. XIII
    except (ValueError, np.linalg.LinAlgError):  # stamps too uneven
        return np.full(values.shape, np.nan), np.full(values.shape, np.nan)
    return curve(time, 1) + mean, curve(time, 2)


def equal_spacing(time: Floats) -> float:
    """The spacing of stamps that are equally spaced to a few roundings, else 0."""
    if len(time) < 2:
        return 0.0
    spacing = float(time[-1] - time[0]) / (len(time) - 1)
    off = np.abs(time - (time[0] + spacing * np.arange(len(time)))).max()
    return spacing if off <= 4.0 * np.finfo(np.float64).eps * max(abs(time[0]), abs(time[-1])) else 0.0


@lru_cache(maxsize=64)
def _filter(spline: bool, width: int, degree: int) -> Floats:
    """(2, width, width) what takes samples a unit apart to their first and second derivatives."""
    if not spline:
        u = np.arange(width, dtype=np.float64) - (width - 1) / 2
        basis = orthonormal(u, u, degree)
        return np.stack([einsum("ki,kj->ij", each, basis.on) for each in (basis.slope, basis.curve)])
    knots = np.concatenate((np.zeros(6), np.arange(3.0, width - 3), np.full(6, width - 1.0)))  # not-a-knot
    at = np.arange(width, dtype=np.float64)[:, None]
    piece = np.minimum(np.searchsorted(knots, at[:, 0], "right"), width) - 1
    B = (np.arange(len(knots) - 1) == piece[:, None]).astype(np.float64)
    slope, curve = np.zeros_like(B), np.zeros_like(B)
    for k in range(1, 6):  # de Boor (1978), ch. X: values and derivatives of B-splines of degree k
        with np.errstate(all="ignore"):
            per = np.where(knots[k:] > knots[:-k], 1.0 / (knots[k:] - knots[:-k]), 0.0)
        left, right = (at - knots[: -k - 1]) * per[:-1], (knots[k + 1 :] - at) * per[1:]
        rise, fall = per[:-1], per[1:]
        curve = left * curve[:, :-1] + right * curve[:, 1:] + 2.0 * (rise * slope[:, :-1] - fall * slope[:, 1:])
        slope = left * slope[:, :-1] + right * slope[:, 1:] + rise * B[:, :-1] - fall * B[:, 1:]
        B = left * B[:, :-1] + right * B[:, 1:]
    inverse = np.linalg.inv(B)
    return np.stack((slope @ inverse, curve @ inverse))


def _filtered(steps: Floats, turns: Floats | None, operator: Floats) -> tuple[Floats, Floats]:
    """Both derivatives (N, c) of samples a unit apart, from the steps (N - 1, c) between them. In the middle those
    as far before as after are taken together, so that a speed is exactly 0 where they cancel."""
    if turns is not None:
        steps = steps - 2.0 * math.pi * np.diff(turns, axis=0)
    of_steps, width = -np.cumsum(operator, axis=2)[:, :, :-1], operator.shape[1]
    half, count = width // 2, len(steps) + 1
    inner = count - width + 1
    found, part = np.empty((2, steps.shape[1], count)), np.empty(inner)
    for k, column in enumerate(np.ascontiguousarray(steps.T)):
        found[:, k, :half] = einsum("dij,j->di", of_steps[:, :half], column[: width - 1])
        found[:, k, inner - 1 + half :] = einsum("dij,j->di", of_steps[:, half:], column[inner - 1 :])
        if inner > 1:
            middle = found[:, k, half : half + inner]
            middle[:] = 0.0
            for i in range(half):
                before, after = column[i : i + inner], column[width - 2 - i : width - 2 - i + inner]
                middle[0] += np.multiply(np.add(before, after, out=part), of_steps[0, half, i], out=part)
                middle[1] += np.multiply(np.subtract(before, after, out=part), of_steps[1, half, i], out=part)
    return found[0].T, found[1].T
