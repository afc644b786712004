"""Which method differentiates a signal best, judged by the noise in it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robodyn.trajectory.derivatives import CENTRAL, SPLINE, Method, equal_spacing, savgol
from robodyn.trajectory.local_polynomials import at_samples
from robodyn.trajectory.noise import Noise, estimate
from robodyn.trajectory.table import FloatArray

Run = tuple[FloatArray, FloatArray, FloatArray]
WINDOWS = (7, 9, 13, 17, 23, 31, 41, 55, 75, 101, 135, 181, 241, 321, 431, 575, 767, 1023, 1365, 1819)
HARMLESS = 1e-3
"""Noise of the spline's derivative, relative to the derivative's rms, below which nothing is smoothed."""
_CENTRES = 1024
_TURNED = 4.0
_RESIDUAL = 2.0


@dataclass(frozen=True)
class Diagnosis:
    """The method for a group of columns, the noise it meets and what it makes of it."""

    method: Method
    quantum: float
    noise: float
    gains: tuple[float, float]
    end_gains: tuple[FloatArray, FloatArray]
    warning: str = ""


def diagnose(runs: Sequence[Run], order: int, mode: str) -> Diagnosis:
    """The method that differentiates these columns best.

    1. The noise s is estimated by `noise.estimate`; a signal without noise, or one that moves in steps or is too coarse
       to tell, gets the quintic spline.
    2. So does a signal whose noise is harmless: s times the spline's gain below 1e-3 of the rms of the derivative.
    3. Otherwise quartic Savitzky-Golay with the window at which the derivative changes least, in the mean square, from
       one window of a geometric series to the next (quasi-optimality: Tikhonov and Glasko 1965). Below it the noise
       changes the derivative more, above it the error of smoothing does. The search ends where that change has risen
       to twice its least value, or the fit leaves more than twice the noise (discrepancy: Morozov 1966).

    Args:
        runs: (time (N,), values as given (N, c), values to differentiate (N, c)) of stretches of the table.
        order: the highest derivative wanted, 1 or 2.
        mode: "auto", or the method to use: "spline", "savgol" (the window as above), "central".
    """
    runs = [run for run in runs if len(run[0]) > 1]
    noise = estimate(runs)
    spacing = np.float64(np.median(np.concatenate([np.diff(time) for time, _, _ in runs])) if runs else 1.0)
    if mode == "central":
        method = CENTRAL
    elif mode == "spline":
        method = SPLINE
    else:
        method = _best_window(runs, order, noise, spacing, smooth=mode == "savgol")
    unit = method.gains
    gains = (float(unit.first / spacing), float(unit.second / spacing / spacing))
    ends = (unit.first_ends / spacing, unit.second_ends / spacing / spacing)
    return Diagnosis(method, noise.quantum, noise.sigma, gains, ends, noise.warning)


def _best_window(runs: Sequence[Run], order: int, noise: Noise, spacing: np.float64, smooth: bool) -> Method:
    runs = [run for run in runs if len(run[0]) >= 2 * WINDOWS[0]]
    if not runs or (noise.sigma == 0.0 and not smooth):
        return savgol(WINDOWS[0]) if smooth else SPLINE
    widest = min(len(time) for time, _, _ in runs) // 2
    methods = [savgol(window) for window in WINDOWS if window <= widest]
    allowed = np.float64(_RESIDUAL * max(noise.sigma, noise.quantum / math.sqrt(12.0))) ** 2
    chosen, least, risen = methods[0], math.inf, 0
    derivative, _ = _sampled(runs, chosen, order)
    now = derivative
    for wider in methods[1:]:
        last, (now, residual) = now, _sampled(runs, wider, order)
        change = float(((now - last) ** 2).mean())
        risen = risen + 1 if change > _TURNED * least else 0
        if risen == 2 or float((residual**2).mean()) > allowed:
            break
        if change < least:
            chosen, least, derivative = wider, change, now
    gain = SPLINE.gains.second if order == 2 else SPLINE.gains.first
    noise_of_spline = np.float64(noise.sigma) * gain / spacing**order
    harmless = bool(noise_of_spline**2 <= HARMLESS**2 * (derivative**2).mean())
    return SPLINE if harmless and not smooth else chosen


def _sampled(runs: Sequence[Run], method: Method, order: int) -> tuple[FloatArray, FloatArray]:
    """Derivative and residual (k, c) at samples spread over the runs, the same samples for every method."""
    count = max(1, _CENTRES // len(runs))
    derivatives, residuals = [], []
    for time, _, values in runs:
        centres = np.unique(np.linspace(0, len(time) - 1, count + 2).astype(np.intp)[1:-1])
        spacing = equal_spacing(time)
        stamps = None if spacing else time
        residual, *rates = at_samples(stamps, values, None, centres, method.window, method.order)
        residuals.append(residual)
        derivatives.append(rates[order - 1] / np.float64(spacing or 1.0) ** order)
    return np.concatenate(derivatives), np.concatenate(residuals)
