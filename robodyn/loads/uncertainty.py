"""How peaks and mean squares change with uncertain parameters, gathered block by block."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.effects.effect import ZeroColumns
from robodyn.dynamics.plan import plan
from robodyn.dynamics.uncertain_parameters import variations
from robodyn.dynamics.varied_loads import derivative_runner, summed
from robodyn.loads.motors import Train
from robodyn.loads.statistics import Integrals
from robodyn.loads.uncertain_peaks import UncertainPeaks
from robodyn.loads.uncertain_quantities import Quantities
from robodyn.programs.run.runner import Runner
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats

ROOM = 4_000_000
"""Numbers of derivatives that are held at a time."""
ROWS = 128
"""Samples that are kept of the whole motion at the most, evenly spread, and half as many at least."""


class Pass(NamedTuple):
    """What is the same for all blocks."""

    executor: str
    threads: int | None
    expected: int


class Kept(NamedTuple):
    """Samples of a motion: time (rows,), columns with derivatives (columns, rows, 1 + m), |qd| (joints, rows)."""

    time: Floats
    columns: Floats
    pace: Floats


class UncertaintyPass:
    """Gathers derivatives by theta, which has m entries.

    Attributes:
        peaks: of the figures' magnitudes, and samples that may be peaks.
        integrals: of "square" (columns,), "product" (columns, m), half the derivative of the squares by all, and of
            gears the "wear" (gears,), "wear change" (gears, m) and "travel".
        kept: evenly spread samples.
    """

    def __init__(
        self, model: Model, scene: Scene, rates: slice, trains: Sequence[tuple[int, Train]], bearings: bool
    ) -> None:
        """Args: rates: entries of tau that are joints; trains: joints with motors; bearings: whether they count."""
        self.model, self.scene = model, scene
        self.found = variations(model, scene)
        self.of = Quantities(model, model.rates[rates], rates, trains, bearings)
        self._m = len(self.found.jacobian)
        self.peaks = UncertainPeaks(self.found, self.of.figures)
        self.integrals = Integrals()
        nothing = np.zeros((self.of.columns, 0, 1 + self._m)), np.zeros((len(self.of.joints), 0))
        self.kept, self._stride, self._seen = Kept(np.zeros(0), *nothing), 1, 0
        self._runners: dict[ZeroColumns, Runner] = {}

    def take(
        self,
        time: Floats,
        first_row: int,
        sources: Mapping[str, Floats],
        loads: Floats,
        motion: tuple[Floats, Floats],
        off: Floats | float,
        how: Pass,
        zero: ZeroColumns,
    ) -> None:
        """Take in a block.

        Args:
            loads: (N, ...) tau, base wrench, and with bearings the wrenches of all other bodies.
            motion: qd and qdd (joints, N).
            off: (joints, N) by how much torques may be off, as peaks of joints are chosen by.
            zero: sources that are zero throughout.
        """
        if zero not in self._runners:
            self._runners[zero] = derivative_runner(plan(self.model, self.scene, zero), self.found, self.of.rows)
        runner = self._runners[zero]
        step = max(2, ROOM // len(runner.program.outputs))
        for start in range(0, len(time), step):
            part = slice(start, start + step)
            given, count = {name: values[part] for name, values in sources.items()}, len(time[part])
            given["theta"] = np.zeros((count, self._m))
            found = runner.run(given, count, executor=how.executor, threads=how.threads, expected=how.expected).values
            qd, qdd = (each[:, part] for each in motion)
            sums = np.array(summed(self.of.rows, list(loads[part].T)))
            values = self.of.with_motors(sums, qd, qdd)
            by_theta = np.moveaxis(found.reshape(count, len(sums), self._m), 1, 0)
            changes = self.of.changes(np.ascontiguousarray(by_theta), qd)
            self._integrate(time[part], values, changes, qd)
            self._keep(time[part], values, changes, qd)
            less = np.zeros((len(self.of.figures), count))
            less[: len(self.of.joints)] = off if isinstance(off, float) else off[:, part]
            self.peaks.take(time[part], first_row + start, values, changes, less)
            self._seen += count

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
