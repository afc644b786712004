"""Covariance of estimates from residuals that are correlated in time and between joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats, einsum

_QUIET, _ROUNDS = 5, 4


def window_length(residual: Floats) -> int:
    """Return after how many samples residuals (N, n) are no longer correlated, times two. The first lag after which
    `_QUIET` autocorrelations in a row are within 2 sqrt(log10(N) / N) (Politis and White, Econometric Reviews 23,
    2004), the largest of all columns; at most a tenth of the samples."""
    N = len(residual)
    bound, most, longest = 2.0 * np.sqrt(np.log10(N) / N), max(1, N // 20), 1
    spectra = np.fft.rfft(residual, 1 << (2 * N - 1).bit_length(), axis=0)
    for products in np.fft.irfft(np.abs(spectra) ** 2, axis=0)[: most + _QUIET].T:
        if products[0] > 0.0:
            loud = np.abs(products / products[0]) > bound
            longest = max(longest, next((m for m in range(most) if not loud[m + 1 : m + 1 + _QUIET].any()), most))
    return 2 * longest


def score_covariance(
    columns: Sequence[Floats], residual: Floats, places: Sequence[Sequence[int]], size: int, bread: Floats | None = None
) -> Floats:
    """Return `sum_st X(s)' C(t - s) X(t)`: the covariance of X' e, for e with the covariance function C of residuals.

    C is that of the residuals, tapered by a flat-top window (Politis and Romano, J. Time Series Analysis 16, 1995), as
    if they did not depend on X. A fit takes its part of the noise, most where its columns x have their frequencies:
    with B = (X'X)^-1 and V the covariance of its estimates, the residual's periodogram of each joint lacks `2 x'Bx C -
    x'Vx`, which is added.

    Args:
        columns: for each joint (N, p_j), at these places among all `size` parameters; residual: (N, n).
        bread: (size, size) B, zero of what was not fitted; None: residuals are of no fit.
    """
    N, length = len(residual), window_length(residual)
    padded = 1 << (2 * N - 1).bit_length()
    lags = np.minimum(np.arange(padded), np.arange(padded, 0, -1))
    taper = np.clip(2.0 * (1.0 - lags / (length + 1.0)), 0.0, 1.0) * (lags <= length)
    spectra = np.fft.rfft(residual, padded, axis=0)
    transforms = [np.fft.rfft(each, padded, axis=0) for each in columns]
    twice = np.full(len(spectra), 2.0 / padded)
    twice[[0, -1]] = 1.0 / padded

    def density(power: NDArray[np.complex128] | Floats) -> NDArray[np.complex128]:
        return np.asarray(np.fft.rfft(np.fft.irfft(power, padded) / N * taper))

    def between(i: int, j: int, of: NDArray[np.complex128] | Floats) -> Floats:
        return np.asarray((np.conj(transforms[i] * (of * twice)[:, None]).T @ transforms[j]).real)

    across = np.zeros((size, size))
    for j, there in enumerate(places):
        for i, here in enumerate(places[:j]):
            block = between(i, j, density(np.conj(spectra[:, i]) * spectra[:, j]))
            across[np.ix_(here, there)] += block
            across[np.ix_(there, here)] += block.T
    lacking = np.zeros(spectra.shape)
    for _ in range(1 if bread is None else _ROUNDS):
        found = across.copy()
        densities = [np.clip(density(power).real, 0.0, None) for power in (np.abs(spectra) ** 2 + lacking).T]
        for j, here in enumerate(places):
            found[np.ix_(here, here)] += between(j, j, densities[j])
        if bread is not None:
            covariance = bread @ found @ bread
            for j, (x, here) in enumerate(zip(transforms, places, strict=True)):
                own = np.ix_(here, here)
                taken = 2.0 * densities[j] * _quadratic(x, bread[own]) - _quadratic(x, covariance[own])
                lacking[:, j] = np.clip(taken, 0.0, None)
    return found


def _quadratic(transforms: NDArray[np.complex128], matrix: Floats) -> Floats:
    """Return x'Ax of each row of transforms."""
    return np.asarray((np.conj(transforms) * (transforms @ matrix)).sum(axis=1).real)


def variance_of_sums(series: Floats, length: int) -> Floats:
    """Return the variance of the sum of each column (N, p), of products less than `length` apart, by Bartlett's taper.
    Newey and West, Econometrica 55, 1987. Unlike `score_covariance` it sees noise that is loud where columns are."""
    total = np.cumsum(np.pad(series, ((length, length), (0, 0))), axis=0)
    parts = total[length:] - total[:-length]
    return np.asarray(einsum("kp,kp->p", parts, parts) / length)
