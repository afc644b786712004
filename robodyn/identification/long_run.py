"""The covariance of estimates from residuals that are correlated in time and between joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import product
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

Spectra = NDArray[np.complex128]
_QUIET = 5
_ROUNDS = 4


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


def score_covariance(
    columns: Sequence[Floats],
    residual: Floats,
    places: Sequence[Sequence[int]],
    size: int,
    bread: Floats | None = None,
) -> Floats:
    """Return `sum_st X(s)' C(t - s) X(t)`: the covariance of X' e, for e with the covariance function C of residuals.

    C is estimated from the residuals, tapered by a flat-top window (Politis and Romano, J. Time Series Analysis 16,
    1995), on the assumption that residuals do not depend on X.

    A fit takes its part of the noise, most where its columns x have their frequencies: with B = (X'X)^-1 and V the
    covariance of its estimates, the residual's periodogram of each joint lacks `2 x'Bx C - x'Vx`, which is added.

    Args:
        columns: for each joint (N, p_j); residual: (N, n).
        places: of the columns of each joint among all parameters; size: how many these are.
        bread: (size, size) B, zero of what was not fitted; None: residuals are of no fit.
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

    def density(power: Floats | Spectra) -> Spectra:
        return np.asarray(np.fft.rfft(np.fft.irfft(power, padded) / N * taper))

    def between(i: int, j: int, of: Floats | Spectra) -> Floats:
        left = np.conj(transforms[i] * (of * twice)[:, None])
        return np.asarray(einsum("fa,fb->ab", left, transforms[j]).real)

    powers = [np.abs(spectrum) ** 2 for spectrum in spectra.T]
    found = np.zeros((size, size))
    for i in range(n):
        for j in range(i + 1, n):
            block = between(i, j, density(np.conj(spectra[:, i]) * spectra[:, j]))
            found[np.ix_(places[i], places[j])] += block
            found[np.ix_(places[j], places[i])] += block.T
    across, lacking = found, [np.zeros(len(spectra))] * n
    for _ in range(1 if bread is None else _ROUNDS):
        densities = [
            np.clip(density(power + more).real, 0.0, None) for power, more in zip(powers, lacking, strict=True)
        ]
        found = across.copy()
        for j, here in enumerate(places):
            found[np.ix_(here, here)] += between(j, j, densities[j])
        if bread is not None:
            lacking = _taken(transforms, densities, places, bread, product(bread, found, bread))
    return found


def _taken(
    transforms: Sequence[Spectra],
    densities: Sequence[Floats],
    places: Sequence[Sequence[int]],
    bread: Floats,
    covariance: Floats,
) -> list[Floats]:
    """Return what a fit took of the periodogram of each joint's noise."""
    found = []
    for x, density, here in zip(transforms, densities, places, strict=True):
        own = np.ix_(here, here)
        found.append(np.clip(2.0 * density * _quadratic(x, bread[own]) - _quadratic(x, covariance[own]), 0.0, None))
    return found


def _quadratic(transforms: Spectra, matrix: Floats) -> Floats:
    """Return x'Ax of each row of transforms."""
    return np.asarray(einsum("fa,fa->f", np.conj(transforms), einsum("fb,ab->fa", transforms, matrix)).real)


def variance_of_sums(series: Floats, length: int) -> Floats:
    """Return the variance of the sum of each column (N, p), of products less than `length` apart, by Bartlett's taper.

    Newey and West, Econometrica 55, 1987. Unlike `score_covariance` it sees noise that is loud where columns are.
    """
    total = np.cumsum(np.pad(series, ((length, length), (0, 0))), axis=0)
    parts = total[length:] - total[:-length]
    return np.asarray(einsum("kp,kp->p", parts, parts) / length)
