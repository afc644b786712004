"""Differentiation matrices for equally spaced samples: quintic spline and local polynomials."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from robodyn.trajectory.table import FloatArray

SPLINE_REACH = 48
"""Samples over which a quintic spline forgets: its influence falls by 0.4306 a sample, to 3e-18 here."""


@dataclass(frozen=True)
class Stencil:
    """Fitted values and derivatives of W samples at unit spacing, as matrices (W, W): `d = first @ values`.

    Of a longer row of samples the middle row serves all but the ends.
    """

    fitted: FloatArray
    first: FloatArray
    second: FloatArray

    @property
    def end_gains(self) -> tuple[FloatArray, FloatArray]:
        """The same as `gains` for the samples from an end to just before the middle."""
        half = len(self.first) // 2
        return np.linalg.norm(self.first[:half], axis=1), np.linalg.norm(self.second[:half], axis=1)

    @property
    def gains(self) -> tuple[float, float]:
        """Standard deviation of the derivatives per standard deviation of white noise, at unit spacing."""
        middle = len(self.first) // 2
        return float(np.linalg.norm(self.first[middle])), float(np.linalg.norm(self.second[middle]))


def apply(matrix: FloatArray, values: FloatArray) -> FloatArray:
    """Derivative (N,) of equally spaced values (N,), N >= W, by one matrix of a stencil of odd width W."""
    width = len(matrix)
    half = width // 2
    inner = np.convolve(values, matrix[half, ::-1], mode="valid")
    return np.concatenate((matrix[:half] @ values[:width], inner, matrix[half + 1 :] @ values[-width:]))


@lru_cache(maxsize=64)
def polynomial(width: int, order: int) -> Stencil:
    """Least-squares polynomial of `order` through `width` samples, differentiated at each: Savitzky and Golay (1964).

    Order 2 through 3 samples is central differences.
    """
    u = np.linspace(-1.0, 1.0, width)
    basis = np.vander(u, order + 1, increasing=True)
    orthonormal, triangle = np.linalg.qr(basis)
    fit = np.linalg.solve(triangle, orthonormal.T)
    powers = np.arange(order + 1)
    slope = np.zeros_like(basis)
    slope[:, 1:] = powers[1:] * basis[:, :-1]
    curve = np.zeros_like(basis)
    curve[:, 2:] = powers[2:] * powers[1:-1] * basis[:, :-2]
    scale = 2.0 / (width - 1)
    return Stencil(basis @ fit, slope @ fit * scale, curve @ fit * scale**2)


@lru_cache(maxsize=8)
def spline(width: int) -> Stencil:
    """Interpolating quintic spline through `width` >= 6 samples, not-a-knot at both ends: de Boor (1978), ch. XIII."""
    return spline_matrices(np.arange(width, dtype=np.float64))


def spline_matrices(time: FloatArray) -> Stencil:
    """The quintic spline's derivatives at its (few) sites, as dense matrices."""
    knots = np.concatenate((np.repeat(time[0], 6), time[3:-3], np.repeat(time[-1], 6)))
    inverse = np.linalg.inv(_basis(knots, time, 5))
    derivatives = (_derivative(knots, time, order) @ inverse for order in (1, 2))
    return Stencil(np.eye(len(time)), *derivatives)


def _basis(knots: FloatArray, x: FloatArray, degree: int) -> FloatArray:
    """B-splines (len(x), len(knots) - degree - 1) by Cox and de Boor's recursion; 0/0 is 0."""
    inside = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, np.searchsorted(knots, knots[-1]) - 1)
    basis: FloatArray = (inside[:, None] == np.arange(len(knots) - 1)).astype(np.float64)
    for d in range(1, degree + 1):
        left, right = _reciprocal(knots[d:-1] - knots[: -d - 1]), _reciprocal(knots[d + 1 :] - knots[1:-d])
        rising = (x[:, None] - knots[: -d - 1]) * left * basis[:, :-1]
        basis = rising + (knots[d + 1 :] - x[:, None]) * right * basis[:, 1:]
    return basis


def _derivative(knots: FloatArray, x: FloatArray, order: int) -> FloatArray:
    """Derivative of the quintic B-splines: differences of those of a lower degree."""
    basis = _basis(knots, x, 5 - order)
    for d in range(6 - order, 6):
        scaled = basis * d * _reciprocal(knots[d:] - knots[:-d])
        basis = scaled[:, :-1] - scaled[:, 1:]
    return basis


def _reciprocal(gaps: FloatArray) -> FloatArray:
    return np.divide(1.0, gaps, out=np.zeros_like(gaps), where=gaps > 0)
