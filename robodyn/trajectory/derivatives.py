"""First and second derivatives of sampled signals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from robodyn.trajectory.stencils import SPLINE_REACH, Stencil, apply, polynomial, spline, spline_matrices
from robodyn.trajectory.table import FloatArray

ORDER = 4
_CELLS = 1 << 15


@dataclass(frozen=True)
class Method:
    """A way to differentiate.

    Args:
        kind: "spline" (interpolating quintic), "savgol" (least-squares polynomial over `window` samples) or "central"
            (parabola through three samples).
        window: odd number of samples; 0 for the spline, which sees them all.
        order: of the polynomial.
    """

    kind: Literal["spline", "savgol", "central"]
    window: int = 0
    order: int = 5

    @property
    def text(self) -> str:
        """The method as the report names it."""
        if self.kind == "savgol":
            return f"Savitzky-Golay (window {self.window}, order {self.order})"
        return "quintic spline" if self.kind == "spline" else "central differences"

    @property
    def halo(self) -> int:
        """Neighbours on either side of a block that make its derivatives those of the whole table."""
        return SPLINE_REACH if self.kind == "spline" else self.window

    @property
    def stencil(self) -> Stencil:
        """The method for equally spaced samples, at unit spacing."""
        return spline(2 * SPLINE_REACH + 1) if self.kind == "spline" else polynomial(self.window, self.order)


SPLINE = Method("spline")
CENTRAL = Method("central", 3, 2)


def savgol(window: int) -> Method:
    """Savitzky-Golay with quartic polynomials."""
    return Method("savgol", window, ORDER)


def differentiate(time: FloatArray, values: FloatArray, method: Method) -> tuple[FloatArray, FloatArray]:
    """(d/dt, d^2/dt^2) of values at their own times.

    Equal spacing (to rounding) is served by one stencil; otherwise the spline and the local polynomials take the stamps
    as they are (no resampling). Fewer samples than the method wants: the polynomial through, or fitted to, them all.

    Args:
        time: (N,) s, increasing, N >= 2 (N >= 3 for a second derivative that is not 0).
        values: (N, c).

    Returns:
        Two arrays (N, c); NaN where stamps are so uneven that the equations are singular.

    Accuracy: the spline's second derivative of sin(2 pi t) at 10 ms: 9e-7 (h^4 / 720 times the sixth derivative), and
    6e-5 at the ends.
    """
    spacing = equal_spacing(time)
    if spacing and len(time) >= len(method.stencil.first):
        stencil = method.stencil
        first = np.stack([apply(stencil.first, column) for column in values.T], axis=1)
        second = np.stack([apply(stencil.second, column) for column in values.T], axis=1)
        return first / spacing, second / spacing / spacing
    if method.kind == "spline" and len(time) >= 6:
        return _by_spline(time, values)
    width = min(len(time), method.window or 5)
    return local_polynomial(time, values, np.arange(len(time)), width, min(method.order, width - 1))[1:]


def equal_spacing(time: FloatArray) -> float:
    """The spacing of stamps that are equally spaced to a few roundings, else 0."""
    if len(time) < 2:
        return 0.0
    spacing = float(time[-1] - time[0]) / (len(time) - 1)
    off = np.abs(time - (time[0] + spacing * np.arange(len(time)))).max()
    return spacing if off <= 4.0 * np.finfo(np.float64).eps * max(abs(time[0]), abs(time[-1])) else 0.0


def _by_spline(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    time = time - time[0]
    try:
        if len(time) <= 2 * SPLINE_REACH:
            stencil = spline_matrices(time)
            return stencil.first @ values, stencil.second @ values
        from scipy.interpolate import make_interp_spline

        curve = make_interp_spline(time, values, k=5)
    except (np.linalg.LinAlgError, ValueError):
        return np.full_like(values, np.nan), np.full_like(values, np.nan)
    return curve(time, 1), curve(time, 2)


def local_polynomial(
    time: FloatArray, values: FloatArray, centres: np.ndarray[tuple[int], np.dtype[np.intp]], width: int, order: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Value and derivatives at some samples of the least-squares polynomial through the `width` samples about each.

    Near an end the window stays inside the table, so the sample is not in its middle.

    Args:
        time: (N,) of any spacing; values: (N, c); centres: (k,) indices; width <= N; order < width.

    Returns:
        (k, c) values, first and second derivatives.
    """
    found = np.empty((3, len(centres), values.shape[1]))
    start = np.clip(centres - width // 2, 0, len(time) - width)
    step = max(1, _CELLS // width)
    for i in range(0, len(centres), step):
        index = start[i : i + step, None] + np.arange(width)
        u = time[index] - time[centres[i : i + step], None]
        scale = np.abs(u).max(axis=1)[:, None]
        fit = _coefficients(u / scale, values[index], order)
        found[0, i : i + step] = fit[:, 0]
        found[1, i : i + step] = fit[:, 1] / scale
        found[2, i : i + step] = 2.0 * fit[:, 2] / scale**2 if order > 1 else 0.0
    return found[0], found[1], found[2]


def _coefficients(u: FloatArray, values: FloatArray, order: int) -> FloatArray:
    """Coefficients (k, order + 1, c) of the least-squares polynomials of values (k, w, c) at u (k, w) in [-1, 1].

    By the normal equations, whose matrix holds the moments of u: quick, and for order 4 or less good to 1e-11.
    """
    moments, sides = [], []
    power = np.ones_like(u)
    for k in range(2 * order + 1):
        moments.append(power.sum(axis=1))
        if k <= order:
            sides.append(np.einsum("kw,kwc->kc", power, values))
        power = power * u
    rows = np.arange(order + 1)
    matrix = np.stack(moments, axis=1)[:, rows[:, None] + rows]
    right = np.stack(sides, axis=1)
    try:
        fit: FloatArray = np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        return np.full_like(right, np.nan)
    return fit
