"""Covariance of least squares whose residuals are correlated from row to row."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robodyn.identification.base import Base
from robodyn.identification.householder import back_substituted, triangular
from robodyn.identification.moments import LAGS, Moments
from robodyn.identification.structure import Structure
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum


def covariance(moments: Moments, structure: Structure, base: Base, R: Floats, sigma: Floats) -> Floats:
    """Return (r, r) the covariance of base parameters that were fitted to rows with weights 1 / sigma.

    T^-1 W T^-T with R^T R = T^T T of the columns of the base and W = sum over joints and lags of rho_lag w_lag C_lag:
    residuals of a joint are taken for stationary, so that their correlation rho at each lag, tapered by Parzen's w,
    meets the sums C of products of columns at that lag (in coordinates in which the columns are orthonormal).
    Residuals are smaller than the noise and of another colour, for a part of it was fitted: rho solves the linear
    equations of what is expected of their products, to the first order (Newey and West 1987 do without).

    Args:
        R: (k, p) weighted rows of the structure's parameters. sigma: (joints,) of the residuals [N m].
    """
    A = R[:, base.independent]
    lengths = np.sqrt(einsum("ij,ij->j", A, A))
    inverse = back_substituted(triangular(A / lengths), np.eye(base.rank)) / lengths[:, None]
    shape = structure.shape[:, base.independent] @ inverse
    C = [
        _symmetric(einsum("ar,lab,bs->lrs", own, sums, own, optimize=True))
        for own, sums in zip(
            (shape[used] / scale for used, scale in zip(structure.atoms.used, sigma, strict=True)),
            moments.columns,
            strict=True,
        )
    ]
    rho, n = _correlations(moments), moments.count
    W = _meat(C, rho)
    for j, own in enumerate(C):
        expected = np.diag(n - np.arange(LAGS + 1.0)) - 2.0 * _lost(einsum("lrr->l", own)) * _taper()
        left = rho[:, j] * (n - np.arange(LAGS + 1.0)) - einsum("lrs,rs->l", own[: LAGS + 1], W)
        rho[:, j] = np.linalg.solve(expected, left)
    values, axes = np.linalg.eigh(_meat(C, rho))
    low, high = _spectrum(rho)
    half = inverse @ axes * np.sqrt(np.clip(values, low, high))
    return np.asarray(half @ half.T)


def _symmetric(C: Floats) -> Floats:
    return np.asarray((C + C.swapaxes(1, 2)) / 2.0)


def _correlations(moments: Moments) -> Floats:
    """Return (LAGS + 1, joints) the mean products of residuals, as they are, in parts of those at lag 0."""
    first = np.where(moments.residuals[0] > 0.0, moments.residuals[0], 1.0)
    rows = moments.count - np.arange(LAGS + 1.0)[:, None]
    return np.asarray(moments.residuals / first * moments.count / np.maximum(rows, 1.0))


def _taper() -> NDArray[np.float64]:
    x = np.arange(LAGS + 1) / (LAGS + 1.0)
    return np.where(x < 0.5, 1.0 - 6.0 * x * x * (1.0 - x), 2.0 * (1.0 - x) ** 3)


def _both() -> NDArray[np.float64]:
    """Return how often each lag counts, forwards and backwards, times its taper."""
    return np.where(np.arange(LAGS + 1) > 0, 2.0, 1.0) * _taper()


def _meat(C: Sequence[Floats], rho: Floats) -> Floats:
    parts = [einsum("l,lrs->rs", _both() * rho[:, j], own[: LAGS + 1]) for j, own in enumerate(C)]
    return np.asarray(np.sum(parts, axis=0))


def _lost(traces: Floats) -> Floats:
    """Return (LAGS + 1, LAGS + 1) how much of the correlation at one lag was fitted from the products at another."""
    lag = np.arange(LAGS + 1)
    half = np.where(lag > 0, 1.0, 0.5)
    return np.asarray((traces[lag[:, None] + lag] + traces[np.abs(lag[:, None] - lag)]) * half)


def _spectrum(rho: Floats) -> tuple[float, float]:
    """Return the least and the largest power of all joints' residuals, between which W lies but for rounding."""
    angles = np.linspace(0.0, np.pi, 8 * LAGS)
    power = np.cos(np.outer(angles, np.arange(LAGS + 1))) @ (_both()[:, None] * rho)
    return max(float(power.min()), 0.0), max(float(power.max()), 0.0)
