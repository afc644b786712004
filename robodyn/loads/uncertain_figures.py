"""From gathered derivatives to error bars: linear where that holds, else by draws of the parameters.

The first term of a figure is its derivative. It is tried with a few draws of the parameters, for which the loads at the
samples that were kept are exact: they are linear in theta, whose entries are polynomials of the parameters. Where the
first term misses them, because the peak is then at another sample, or a load that is small is made by the errors
themselves, the figure is drawn often instead.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robodyn.loads.drawn import Drawn
from robodyn.loads.uncertain_quantities import Figure
from robodyn.loads.uncertainty import UncertaintyPass
from robodyn.programs.vectors import product
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

DRAWS, SEED = 20_000, 19
TRIED = 400
"""Draws with which the first term is tried."""
SHIFT, SCATTER = 0.01, 0.03
"""Of the standard error: the mean and the standard deviation of what the first term may miss."""
TOGETHER = 1000
"""Draws that are evaluated together."""
TINY = 1e-300


class Figures:
    """Figures of a motion, of everything that a pass has gathered."""

    def __init__(self, gathered: UncertaintyPass) -> None:
        self.of = gathered
        x = gathered.found.even_draws(DRAWS, SEED)
        self.theta = gathered.found.theta(x)
        self._linear = product(x, gathered.found.jacobian.T)
        self._peaks: dict[int, Drawn] = {}
        self._rms: dict[int, Drawn] = {}

    def magnitudes(self, figure: Drawn) -> Floats:
        """Return a figure's magnitude for all draws, the same ones for all figures."""
        if figure.curved is not None:
            return figure.curved
        return np.asarray(abs(figure.value) + product(self._linear, figure.gradient))

    def peak(self, k: int) -> Drawn:
        """Return the largest magnitude of figure k."""
        if k not in self._peaks:
            of, figure = self.of.peaks, self.of.of.figures[k]
            columns = len(figure.columns)
            at = of.at[k][:columns]
            value = at[0, 0] if columns == 1 else figure.size(at[:, 0])
            samples = np.concatenate((at[None], of.rivals[k][:, :columns]))
            less = np.append(0.0, of.less[k] - float(of.peaks.kept["off"][k]))
            flat, used = _used(samples.reshape(-1, samples.shape[-1]))

            def drawn(theta: Floats) -> Floats:
                loads = flat[:, 0] + product(theta[:, used], flat[:, 1:].T)
                sizes = figure.size(np.moveaxis(loads.reshape(len(theta), -1, columns), -1, 0))
                return np.asarray((sizes - less).max(axis=1))

            self._peaks[k] = self._figure(float(value), figure.gradient(at[:, 0], at[:, 1:]), at[:, 1:], drawn)
        return self._peaks[k]

    def rms(self, k: int) -> Drawn:
        """Return the RMS of figure k; its magnitude in a motion without duration."""
        totals, duration = self.of.integrals.totals, self.of.integrals.duration
        if duration <= 0.0:
            found = self.peak(k)
            return found._replace(value=abs(found.value))
        if k not in self._rms:
            figure = self.of.of.figures[k]
            square, slope = (totals[name][figure.columns].sum(0) / duration for name in ("square", "product"))
            self._rms[k] = self._mean(figure, 2, float(square), 2.0 * slope, _shares(self.of.kept.time))
        return self._rms[k]

    def cubic(self, i: int) -> Drawn:
        """Return the cubic mean of what gear i bears."""
        totals, of = self.of.integrals.totals, self.of.of
        travel = float(totals["travel"][i]) or 1.0
        figure = [figure for figure in of.figures if figure.name == "gear"][i]
        share = _shares(self.of.kept.time) * self.of.kept.pace[of.trains[i][0]]
        cube, slope = float(totals["wear"][i]) / travel, 3.0 * totals["wear change"][i] / travel
        return self._mean(figure, 3, cube, slope, share / (share.sum() + TINY))

    def _mean(self, figure: Figure, power: int, whole: float, slope: Floats, share: Floats) -> Drawn:
        """Return the power mean of a figure's magnitude.

        Args:
            whole: the mean of the power at all samples; slope: (m,) its derivative.
            share: of each sample that was kept, of which the higher orders are.
        """
        kept = self.of.kept.columns[figure.columns]
        flat, used = _used(kept.reshape(-1, kept.shape[-1]))
        root = cube_roots if power == 3 else np.sqrt
        size = float(root(np.array(whole)))
        at = kept[..., 0]
        own = power * einsum("cn,cnm->m", figure.half(at) * figure.size(at) ** (power - 2) * share, kept[..., 1:])
        first, before = (slope - own)[used], _powers(figure.size(at), power, share)

        def drawn(theta: Floats) -> Floats:
            some = theta[:, used]
            loads = flat[:, 0] + product(some, flat[:, 1:].T)
            sizes = figure.size(np.moveaxis(loads.reshape(len(some), len(kept), -1), 1, 0))
            change = _powers(sizes, power, share) - before + product(some, first)
            return np.asarray(root(np.maximum(whole + change, 0.0)))

        gradient = slope / (power * size ** (power - 1)) if size else np.zeros(len(slope))
        return self._figure(size, gradient, kept[..., 1:].reshape(-1, len(slope)), drawn)

    def _figure(self, value: float, gradient: Floats, rows: Floats, drawn: Callable[[Floats], Floats]) -> Drawn:
        """Return a figure, drawn where its first term is not all.

        Args:
            rows: (n, m) derivatives of all that it is made of. drawn: its magnitudes for draws of theta.
        """
        error = math.sqrt(float(self.of.found.variance(gradient)))
        missed = drawn(self.theta[:TRIED]) - abs(value) - product(self._linear[:TRIED], gradient)
        if abs(float(missed.mean())) <= SHIFT * error and float(missed.std()) <= SCATTER * error:
            return Drawn(value, error, gradient, self._parts(gradient[None]))
        if float(np.abs(missed).max()) <= 1e-12 * abs(value):
            return Drawn(value, error, gradient, self._parts(gradient[None]))
        curved = [drawn(self.theta[k : k + TOGETHER]) for k in range(0, DRAWS, TOGETHER)]
        return Drawn(value, error, gradient, self._parts(rows), np.concatenate(curved))

    def _parts(self, rows: Floats) -> Floats:
        """Return (k,) what each parameter adds to the variance of what has these derivatives (n, m), in all."""
        along = self.of.found.along(rows)
        L = self.of.found.factor
        return np.asarray((along * (along if L is None else product(product(along, L), L.T))).sum(0))


def _used(rows: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Return rows of values and derivatives (n, 1 + m) without those that are all zero, and which of theta are left."""
    used = np.flatnonzero(rows[:, 1:].any(axis=0))
    return np.concatenate((rows[:, :1], rows[:, 1:][:, used]), 1), used


def _powers(sizes: Floats, power: int, share: Floats) -> Floats:
    """Return the mean of a power of magnitudes (..., n)."""
    return np.asarray(einsum("...n,n->...", sizes * sizes if power == 2 else sizes * sizes * sizes, share))


def cube_roots(x: Floats) -> Floats:
    """Return cube roots by the C library: NumPy's own function ends in other digits with AVX-512."""
    return np.array([each ** (1 / 3) for each in x.ravel().tolist()]).reshape(x.shape)


def _shares(time: Floats) -> Floats:
    """Return the share of the time that each of some samples stands for."""
    if len(time) < 2:
        return np.ones(len(time))
    weights = np.gradient(time)
    weights[[0, -1]] *= 0.5
    return np.asarray(weights / weights.sum())
