"""The covariance of estimates from residuals that are correlated in time and between joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robodyn.support.floats import Floats

_QUIET = 5


def window_length(residual: Floats) -> int:
    """Return after how many samples residuals are no longer correlated, times two.

    The first lag after which `_QUIET` autocorrelations in a row are within 2 sqrt(log10(N) / N) (Politis and White,
    Econometric Reviews 23, 2004), the largest of all columns; at most a tenth of the samples.

    Args:
        residual: (N, n).
    """
    N = len(residual)
    bound, most = 2.0 * np.sqrt(np.log10(N) / N), max(1, N // 20)
    longest = 1
    for column in residual.T:
        covariance = _products(column, column, most + _QUIET)
        if covariance[0] > 0.0:
            loud = np.abs(covariance / covariance[0]) > bound
            last = next((m for m in range(most) if not loud[m + 1 : m + 1 + _QUIET].any()), most)
            longest = max(longest, last)
    return 2 * longest


def _products(a: Floats, b: Floats, lags: int) -> Floats:
    """Return sum_t a(t) b(t + lag) / N for lags from 0."""
    N = len(a)
    size = 1 << (2 * N - 1).bit_length()
    products = np.fft.irfft(np.conj(np.fft.rfft(a, size)) * np.fft.rfft(b, size), size)
    return np.asarray(products[:lags] / N)


def score_covariance(columns: Sequence[Floats], residual: Floats, places: Sequence[Sequence[int]], size: int) -> Floats:
    """Return `sum_st X(s)' C(t - s) X(t)`: the covariance of X' e, for e with the covariance function C of residuals.

    C is estimated from the residuals, tapered by a flat-top window (Politis and Romano, J. Time Series Analysis 16,
    1995), on the assumption that residuals do not depend on X.

    Args:
        columns: for each joint (N, p_j); residual: (N, n).
        places: of the columns of each joint among all parameters; size: how many these are.
    """
    N, n = residual.shape
    length = window_length(residual)
    padded = 1 << (2 * N - 1).bit_length()
    taper = np.zeros(padded)
    lags = np.arange(length + 1)
    weight = np.clip(2.0 * (1.0 - lags / (length + 1.0)), 0.0, 1.0)
    taper[lags], taper[-lags[1:]] = weight, weight[1:]
    spectra = np.fft.rfft(residual, padded, axis=0)
    transforms = [np.fft.rfft(each, padded, axis=0) for each in columns]
    twice = np.full(len(spectra), 2.0 / padded)
    twice[[0, -1]] = 1.0 / padded
    found = np.zeros((size, size))
    for i in range(n):
        for j in range(i, n):
            cross = np.fft.irfft(np.conj(spectra[:, i]) * spectra[:, j], padded) / N
            density = np.fft.rfft(cross * taper) * twice
            if i == j:
                density = np.clip(density.real, 0.0, None)
            left = np.conj(transforms[i] * density[:, None])
            block = np.einsum("fa,fb->ab", left, transforms[j]).real
            found[np.ix_(places[i], places[j])] += block
            if i != j:
                found[np.ix_(places[j], places[i])] += block.T
    return found
