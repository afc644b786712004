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
from robodyn.loads.uncertainty import UncertaintyPass
from robodyn.programs.vectors import product
from robodyn.support.floats import Floats

DRAWS, SEED = 10_000, 19
TRIED = 400
"""Draws with which the first term is tried."""
SHIFT, SCATTER = 0.02, 0.1
"""Of the standard error: the mean and the standard deviation of what the first term may miss."""
OUT_OF_REACH = 5.0
"""Standard errors that a sample is below the peak by, which then never rises to it."""
TINY = 1e-300


class Figures:
    """Figures of a motion, of everything that a pass has gathered."""

    def __init__(self, gathered: UncertaintyPass) -> None:
        self.of = gathered
        x = gathered.found.draws(DRAWS, SEED)
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
            at = self.of.at[k]
            size = float(np.sqrt((at[:, 0] ** 2).sum()))
            gradient = product(at[:, 0], at[:, 1:]) / size if size else np.zeros(at.shape[1] - 1)
            value = float(at[0, 0]) if self.of.of.figures[k].b < 0 else size
            samples, less = self._rivals(k, size, gradient)

            flat, used = _used(samples.reshape(-1, samples.shape[-1]))

            def drawn(theta: Floats) -> Floats:
                columns = (flat[:, 0] + product(theta[:, used], flat[:, 1:].T)).reshape(-1, len(samples), 2)
                return np.asarray((np.sqrt((columns * columns).sum(-1)) - less).max(axis=1))

            self._peaks[k] = self._figure(value, gradient, at[:, 1:], drawn)
        return self._peaks[k]

    def _rivals(self, k: int, size: float, gradient: Floats) -> tuple[Floats, Floats]:
        """Return the samples (n, 2, 1 + m) that may be the peak, itself first, and (n,) what is not sure of them.

        A sample of the opposite sign may be one too.
        """
        at, more = self.of.at[k], self.of.contenders[k]
        less = self.of.less[k] - float(self.of.peaks.kept["off"][k])
        sizes = np.sqrt((more[:, :, 0] ** 2).sum(1))
        slopes = np.einsum("mi,mik->mk", more[:, :, 0], more[:, :, 1:]) / (sizes + TINY)[:, None]
        across = self.of.found.variance(more[:, :, 1:]).sum(1)
        near = np.zeros(len(more), dtype=bool)
        for sign in (1.0, -1.0):
            spread = np.sqrt(self.of.found.variance(gradient - sign * slopes)) + np.sqrt(across) * (
                sizes < np.sqrt(across)
            )
            near |= size - sign * sizes + less <= OUT_OF_REACH * spread
        return np.concatenate((at[None], more[near])), np.append(0.0, less[near])

    def rms(self, k: int) -> Drawn:
        """Return the RMS of figure k; its magnitude in a motion without duration."""
        totals, duration = self.of.integrals.totals, self.of.integrals.duration
        if duration <= 0.0:
            found = self.peak(k)
            return found._replace(value=abs(found.value))
        if k not in self._rms:
            figure = self.of.of.figures[k]
            columns = [figure.a] if figure.b < 0 else [figure.a, figure.b]
            size = math.sqrt(float(totals["square"][columns].sum()) / duration)
            gradient = totals["product"][columns].sum(0) / (duration * size) if size else np.zeros(self.theta.shape[1])
            kept, share = self.of.kept.columns[columns], _shares(self.of.kept.time)
            rows, used = _used(kept.reshape(-1, kept.shape[-1]))
            A = product((rows * np.tile(share, len(columns))[:, None]).T, rows)

            def drawn(theta: Floats) -> Floats:
                some = theta[:, used]
                squares = A[0, 0] + 2.0 * product(some, A[0, 1:])
                squares = squares + np.einsum("ni,ni->n", product(some, A[1:, 1:]), some)
                roots = np.sqrt(np.maximum(squares, 0.0))
                return np.asarray(np.maximum(roots + (size - math.sqrt(max(float(A[0, 0]), 0.0))), 0.0))

            self._rms[k] = self._figure(size, gradient, kept[..., 1:].reshape(-1, len(gradient)), drawn)
        return self._rms[k]

    def cubic(self, i: int) -> Drawn:
        """Return the cubic mean of what gear i bears."""
        totals, of = self.of.integrals.totals, self.of.of
        travel, wear = float(totals["travel"][i]), float(totals["wear"][i])
        size = (wear / travel) ** (1 / 3) if travel else 0.0
        gradient = totals["wear change"][i] / (travel * size * size) if size else np.zeros(self.theta.shape[1])
        column = [figure.a for figure in of.figures if figure.name == "gear"][i]
        share = _shares(self.of.kept.time) * self.of.kept.pace[of.trains[i][0]]
        share = share / (share.sum() + TINY)
        rows, used = _used(self.of.kept.columns[column])

        def mean(load: Floats) -> Floats:
            return cube_roots(np.einsum("...r,r->...", np.abs(load * load * load), share))

        def drawn(theta: Floats) -> Floats:
            found = mean(rows[:, 0] + product(theta[:, used], rows[:, 1:].T))
            return np.asarray(np.maximum(found + (size - float(mean(rows[:, 0]))), 0.0))

        return self._figure(size, gradient, self.of.kept.columns[column][:, 1:], drawn)

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
        return Drawn(value, error, gradient, self._parts(rows), drawn(self.theta))

    def _parts(self, rows: Floats) -> Floats:
        """Return (k,) what each parameter adds to the variance of what has these derivatives (n, m), in all."""
        along = self.of.found.along(rows)
        L = self.of.found.factor
        return np.asarray((along * (along if L is None else product(product(along, L), L.T))).sum(0))


def _used(rows: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Return rows of values and derivatives (n, 1 + m) without those that are all zero, and which of theta are left."""
    used = np.flatnonzero(rows[:, 1:].any(axis=0))
    return np.concatenate((rows[:, :1], rows[:, 1:][:, used]), 1), used


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
