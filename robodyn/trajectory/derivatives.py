"""First and second derivatives of sampled signals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from robodyn.trajectory.stencils import SPLINE_REACH, Stencil, apply, polynomial, spline, spline_matrices
from robodyn.trajectory.table import FloatArray

ORDER = 4
_CELLS = 1 << 20


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
        Two arrays (N, c).

    Accuracy: the spline's second derivative of sin(2 pi t) at 10 ms: 9e-7 (h^4 / 720 times the sixth derivative), and
    4e-5 at the ends.
    """
    spacing = equal_spacing(time)
    if spacing and len(time) >= len(method.stencil.first):
        stencil = method.stencil
        first = np.stack([apply(stencil.first, column) for column in values.T], axis=1)
        second = np.stack([apply(stencil.second, column) for column in values.T], axis=1)
        return first / spacing, second / spacing / spacing
    if method.kind == "spline" and len(time) > 6:
        return _by_spline(time, values)
    width = min(len(time), method.window or 6)
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
    if len(time) <= 2 * SPLINE_REACH:
        stencil = spline_matrices(time)
        return stencil.first @ values, stencil.second @ values
    from scipy.interpolate import make_interp_spline

    curve = make_interp_spline(time, values, k=5)
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
    fitted, first, second = np.empty((3, len(centres), values.shape[1]))
    start = np.clip(centres - width // 2, 0, len(time) - width)
    step = max(1, _CELLS // width)
    for i in range(0, len(centres), step):
        part = slice(i, i + step)
        index = start[part, None] + np.arange(width)
        u = time[index] - time[centres[part], None]
        scale = np.abs(u).max(axis=1, initial=0.0)
        basis = np.vander((u / scale[:, None]).ravel(), order + 1, increasing=True).reshape(*u.shape, order + 1)
        orthonormal, triangle = np.linalg.qr(basis)
        fit = np.linalg.solve(triangle, orthonormal.transpose(0, 2, 1) @ values[index])
        fitted[part] = fit[:, 0]
        first[part] = fit[:, 1] / scale[:, None]
        second[part] = 2.0 * fit[:, 2] / scale[:, None] ** 2 if order > 1 else 0.0
    return fitted, first, second
