"""Monte Carlo: the motion run again with drawn parameters, as a comparison for error bars."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from robodyn.dynamics.plan import plan
from robodyn.dynamics.varied_loads import varied_runner
from robodyn.loads.statistics import Integrals
from robodyn.loads.uncertain_figures import cube_roots
from robodyn.loads.uncertain_quantities import Quantities
from robodyn.loads.uncertainty import UncertaintyPass
from robodyn.support.floats import Floats

SEED = 1905
ROOM = 4_000_000
"""Numbers of loads that are held at a time."""


class SamplePass:
    """Runs every block with every draw of the parameters.

    Attributes:
        peaks: (figures, draws) of magnitudes.
    """

    def __init__(self, beside: UncertaintyPass, count: int) -> None:
        """Args: beside: whose parameters and quantities are taken; count: draws."""
        self.of: Quantities = beside.of
        self.runner = varied_runner(plan(beside.model, beside.scene), beside.found, beside.of.rows)
        self.theta = beside.found.theta(beside.found.draws(count, SEED))
        self.peaks = np.zeros((len(self.of.figures), count))
        self._integrals = [Integrals() for _ in self.theta]
        self._gears = [figure.a for figure in self.of.figures if figure.name == "gear"]

    def take(
        self,
        time: Floats,
        sources: Mapping[str, Floats],
        motion: tuple[Floats, Floats],
        executor: str,
        threads: int | None,
    ) -> None:
        """Take in a block; motion: qd and qdd (joints, N)."""
        step = max(2, ROOM // len(self.runner.program.outputs))
        for start in range(0, len(time), step):
            part = slice(start, start + step)
            given, of = {name: values[part] for name, values in sources.items()}, time[part]
            qd, qdd = (each[:, part] for each in motion)
            for k, theta in enumerate(self.theta):
                given["theta"] = np.broadcast_to(theta, (len(of), len(theta)))
                expected = len(self.theta) * len(of)
                sums = self.runner.run(given, len(of), executor=executor, threads=threads, expected=expected).values
                self._gather(k, of, self.of.with_motors(np.ascontiguousarray(sums.T), qd, qdd), qd)

    def _gather(self, k: int, time: Floats, values: Floats, qd: Floats) -> None:
        """Take in the columns of a block for draw k."""
        a, b = self.of.pairs
        squares = values[a] * values[a] + np.where((b < 0)[:, None], 0.0, values[b] * values[b])
        self.peaks[:, k] = np.maximum(self.peaks[:, k], np.sqrt(squares.max(axis=1)))
        quantities = {"square": squares}
        if self._gears:
            load, pace = np.abs(values[self._gears]), np.abs(qd[[joint for joint, _ in self.of.trains]])
            quantities |= {"wear": load * load * load * pace, "travel": pace}
        self._integrals[k].update(time, quantities)

    def rms(self, figure: int) -> Floats:
        """Return (draws,) the RMS of a figure; its magnitude in a motion without duration."""
        if self._integrals[0].duration <= 0.0:
            return np.array(self.peaks[figure])
        means = [float(each.totals["square"][figure]) / each.duration for each in self._integrals]
        return np.asarray(np.sqrt(means))

    def cubic(self, i: int) -> Floats:
        """Return (draws,) the cubic mean of what gear i bears."""
        totals = [each.totals for each in self._integrals]
        means = [float(each["wear"][i] / each["travel"][i]) if each["travel"][i] else 0.0 for each in totals]
        return cube_roots(np.array(means))
