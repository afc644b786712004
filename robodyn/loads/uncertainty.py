"""How peaks and mean squares change with uncertain parameters theta (m,), gathered block by block.

Samples that may be the peak where parameters are uncertain are those that are it for some draws.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.effects.effect import ZeroColumns
from robodyn.dynamics.plan import plan
from robodyn.dynamics.uncertain_parameters import misfits, variations
from robodyn.dynamics.variations import Variations
from robodyn.dynamics.varied_loads import derivative_runner, summed
from robodyn.loads.motors import Train
from robodyn.loads.statistics import Greatest, Integrals
from robodyn.loads.uncertain_quantities import Figure, Quantities
from robodyn.programs.run.runner import Runner
from robodyn.programs.vectors import product
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum
from robodyn.support.wording import shown
from robodyn.trajectory.motion import Trajectory

DRAWS, SEED = 64, 190
WIDER = 1.5
"""Times the standard deviations that these draws have, so that the ends of intervals find their samples too."""
OUT_OF_REACH = 8.0
"""Standard errors that a sample is below the peak by, which then never rises to it."""


class UncertainPeaks:
    """Gathers the peaks of figures, and the samples that are the peak instead for some draws, block by block.

    Attributes:
        at: (figures, 2, 1 + m) the columns of the peak, and their derivatives by theta.
        rivals: of each figure (samples, 2, 1 + m) likewise, of the samples that are the peak for some draws.
    """

    def __init__(self, found: Variations, figures: Sequence[Figure]) -> None:
        self.found, self.figures = found, figures
        count, width = len(figures), 1 + len(found.jacobian)
        self.peaks, self.at = Greatest(count), np.zeros((count, 2, width))
        self.rivals = [np.zeros((0, 2, width))] * count
        self._theta = found.theta(WIDER * found.even_draws(DRAWS, SEED))
        self._most, self._which = np.full((count, DRAWS), -np.inf), np.zeros((count, DRAWS), dtype=np.int64)

    def take(self, time: Floats, row: int, values: Floats, changes: Floats) -> None:
        """Take in a block from this row on: all columns (columns, N), and by theta (columns, N, m)."""
        along = self.found.spread(changes)
        sizes = np.stack([each.size(values[each.columns]) for each in self.figures])
        for figure, at in self.peaks.update(time, row, sizes):
            self.at[figure] = self._both(figure, np.array([at]), values, changes)[0]
        for k, each in enumerate(self.figures):
            columns = each.columns
            near = self._near(k, values[columns], along[columns], sizes[k])
            if len(near):
                drawn = values[columns][:, near, None] + product(changes[columns][:, near], self._theta.T)
                self._choose(k, near, each.size(drawn), values, changes)

    def _near(self, k: int, values: Floats, along: Floats, sizes: Floats) -> NDArray[np.int64]:
        """Return the samples of figure k, of magnitudes (N,), that may rise to its peak.

        Args:
            values: (1 or 2, N); along: (1 or 2, N, p) of `Variations.spread`.
        """
        figure, at = self.figures[k], self.at[k, : len(values)]
        at_peak = self.found.spread(at[:, 1:])
        apart = figure.gradient(values, along) - figure.gradient(at[:, 0], at_peak)
        spread, errors = np.sqrt(einsum("nk,nk->n", apart, apart)), einsum("cnk,cnk->cn", along, along)
        across, gap = np.sqrt(errors.sum(0)), float(self.peaks.score[k]) - sizes
        turns = sizes < OUT_OF_REACH * across
        if figure.lossy:
            turns |= np.abs(values[1]) < OUT_OF_REACH * np.sqrt(errors[1])
        own = np.sqrt(einsum("cp,cp->", at_peak, at_peak))
        return np.flatnonzero(gap <= OUT_OF_REACH * np.where(turns, across + own, spread))

    def _choose(self, k: int, near: NDArray[np.int64], drawn: Floats, values: Floats, changes: Floats) -> None:
        """Keep the samples where figure k is largest for some draw; drawn: (samples, draws)."""
        best = drawn.argmax(0)
        levels = np.take_along_axis(drawn, best[None], 0)[0]
        new = levels > self._most[k]
        if not new.any():
            return
        self._most[k] = np.where(new, levels, self._most[k])
        came, places = np.unique(near[best], return_inverse=True)
        which = np.where(new, len(self.rivals[k]) + places, self._which[k])
        left, self._which[k] = np.unique(which, return_inverse=True)
        rows = np.concatenate((self.rivals[k], self._both(k, came, values, changes)))
        self.rivals[k] = rows[left]

    def _both(self, figure: int, at: NDArray[np.int64], values: Floats, changes: Floats) -> Floats:
        """Return (samples, 2, 1 + m) the columns of a figure at some samples, and their derivatives."""
        found = np.zeros((len(at), 2, 1 + changes.shape[-1]))
        for i, c in enumerate(self.figures[figure].columns):
            found[:, i, 0], found[:, i, 1:] = values[c, at], changes[c, at]
        return found


ROOM = 4_000_000
"""Numbers of derivatives that are held at a time."""
ROWS = 128
"""Samples that are kept of the whole motion at the most, evenly spread, and half as many at least."""


class Kept(NamedTuple):
    """Samples of a motion: time (rows,), columns with derivatives (columns, rows, 1 + m), |qd| (joints, rows)."""

    time: Floats
    columns: Floats
    pace: Floats


class UncertaintyPass:
    """Gathers derivatives by theta.

    Attributes:
        notes: warnings.
        integrals: of "square" (columns,), "product" (columns, m), half the derivative of the squares by all, and of
            gears the "wear" (gears,), "wear change" (gears, m) and "travel".
        kept: evenly spread samples.
    """

    def __init__(
        self,
        model: Model,
        scene: Scene,
        rates: slice,
        trains: Sequence[tuple[int, Train]],
        bearings: bool,
        executor: str = "auto",
        threads: int | None = None,
    ) -> None:
        """Args: rates: entries of tau that are joints; trains: joints with motors; bearings: whether they count."""
        self.model, self.scene, self.rates, self.executor, self.threads = model, scene, rates, executor, threads
        self.notes = (*misfits(model, scene), *_beyond(scene))
        self.found = variations(model, scene)
        self.of = Quantities(model, model.rates[rates], rates, trains, bearings)
        self._m = len(self.found.jacobian)
        self.peaks = UncertainPeaks(self.found, self.of.figures)
        self.integrals = Integrals()
        nothing = np.zeros((self.of.columns, 0, 1 + self._m)), np.zeros((len(self.of.joints), 0))
        self.kept, self._stride, self._seen = Kept(np.zeros(0), *nothing), 1, 0
        self._runners: dict[ZeroColumns, Runner] = {}

    def take(
        self, block: Trajectory, sources: Mapping[str, Floats], loads: Floats, zero: ZeroColumns, expected: int
    ) -> None:
        """Take in a block.

        Args:
            loads: (N, ...) tau, base wrench, and with bearings the wrenches of all other bodies.
            zero: sources that are zero throughout. expected: samples of the motion.
        """
        if zero not in self._runners:
            self._runners[zero] = derivative_runner(plan(self.model, self.scene, zero), self.found, self.of.rows)
        runner = self._runners[zero]
        step = max(2, ROOM // len(runner.program.outputs))
        for start in range(0, len(block), step):
            part = slice(start, start + step)
            time = block.time[part]
            given = {name: values[part] for name, values in sources.items()}
            given["theta"] = np.zeros((len(time), self._m))
            found = runner.run(given, len(time), executor=self.executor, threads=self.threads, expected=expected).values
            qd, qdd = (np.ascontiguousarray(each[part, self.rates].T) for each in (block.qd, block.qdd))
            sums = np.array(summed(self.of.rows, list(loads[part].T)))
            values = self.of.with_motors(sums, qd, qdd)
            by_theta = np.moveaxis(found.reshape(len(time), len(sums), self._m), 1, 0)
            changes = self.of.changes(np.ascontiguousarray(by_theta), qd)
            self._integrate(time, values, changes, qd)
            self._keep(time, values, changes, qd)
            self.peaks.take(time, block.first_row + start, values, changes)
            self._seen += len(time)

    def _integrate(self, time: Floats, values: Floats, changes: Floats, qd: Floats) -> None:
        halves = self.of.halves(values)
        quantities = {"square": halves * values, "product": np.moveaxis(halves[..., None] * changes, -1, 1)}
        if self.of.trains:
            gears = [figure.a for figure in self.of.figures if figure.name == "gear"]
            pace = np.abs(qd[[k for k, _ in self.of.trains]])
            load, by = values[gears], changes[gears]
            quantities["travel"] = pace
            quantities["wear"] = np.abs(load * load * load) * pace
            quantities["wear change"] = np.moveaxis((load * np.abs(load) * pace)[..., None] * by, -1, 1)
        self.integrals.update(time, quantities)

    def _keep(self, time: Floats, values: Floats, changes: Floats, qd: Floats) -> None:
        """Keep every so many-th sample; twice as few whenever there are too many."""
        while (self._seen + len(time)) / self._stride > ROWS:
            self._stride *= 2
            self.kept = Kept(self.kept.time[::2], self.kept.columns[:, ::2], self.kept.pace[:, ::2])
        rows = np.arange(-self._seen % self._stride, len(time), self._stride)
        columns = np.concatenate((values[:, rows, None], changes[:, rows]), -1)
        news = Kept(time[rows], columns, np.abs(qd[:, rows]))
        self.kept = Kept(
            np.concatenate((self.kept.time, news.time)),
            np.concatenate((self.kept.columns, news.columns), 1),
            np.concatenate((self.kept.pace, news.pace), 1),
        )


GROWING = 0.1
"""Friction that grows with load more than this may put error bars off by more than 5 %."""


def _beyond(scene: Scene) -> tuple[str, ...]:
    """Return a warning where friction may change sides, which error bars do not follow."""
    names = [name for name in scene.loaded if scene.friction[name].load > GROWING]
    if not names:
        return ()
    what = f"friction of {', '.join(map(shown, names))} grows with more than {100 * GROWING:.3g} % of the load"
    return (f"{what}: where that load is about zero, error bars may be off by more than 5 %",)
