"""What a first pass over a log tells."""

from __future__ import annotations

import numpy as np

from robodyn.errors import TrajectoryError
from robodyn.robot.model import Model
from robodyn.support.floats import Floats
from robodyn.trajectory.motion import Trajectory

GAP = 4.5
"""So many steps without a row part a log in stretches."""
_EVEN = 1e-3
"""Stamps that are off an even grid by less than this part of a step are taken for even."""
_FEWEST = 64
"""Rows up to which nothing is compared."""
SIGHT = 1 << 17
"""Samples from whose torques the noise is told."""
REMEDY = "is it the right log, and are torques recorded?"


class Scan:
    """What a first pass over a log tells, in memory that does not grow with it.

    Attributes:
        seen: the first blocks; last: the last one; rows: of the table.
    """

    def __init__(self, model: Model) -> None:
        self.model, self.rows = model, 0
        self.seen: list[Trajectory] = []
        self.last: Trajectory
        self._low, self._high = np.full(model.n, np.inf), np.full(model.n, -np.inf)
        self._typical, self._steps = 0.0, (0, 0.0, np.inf, 0.0)

    def add(self, block: Trajectory) -> None:
        """Take in the next block."""
        steps = np.diff(block.time, prepend=self.last.time[-1]) if self.rows else np.diff(block.time)
        if not self.rows and len(steps):
            self._typical = float(np.median(steps))
        near = steps[steps < GAP * self._typical]
        count, total, least, most = self._steps
        shortest, longest = float(near.min(initial=least)), float(near.max(initial=most))
        self._steps = count + len(near), total + float(near.sum()), shortest, longest
        tau = measured_torques(block, self.model)
        self._low, self._high = np.minimum(self._low, tau.min(axis=0)), np.maximum(self._high, tau.max(axis=0))
        self.rows, self.last = self.rows + len(block), block
        if sum(map(len, self.seen)) < SIGHT:
            self.seen.append(block)

    def measured(self, path: str) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Return which torques are measured, as places in the rates, and which of the columns never change."""
        there = [i for i, name in enumerate(self.model.rates) if f"tau_{name}" in self.last.extra]
        if not there:
            what = "gives no torque of a joint: no column tau_<joint> and no effort"
            raise TrajectoryError(what, remedy="name one by --map tau_JOINT=COLUMN", file=path)
        varying = tuple(i for i in there if self._high[i] > self._low[i])
        if not varying:
            raise TrajectoryError("no measured torque ever changes: nothing was measured", remedy=REMEDY, file=path)
        return varying, tuple(i for i in there if i not in varying)

    def grid(self, path: str) -> tuple[float, bool]:
        """Return the mean step where there is no gap [s], and whether all such steps are alike."""
        if self.rows <= _FEWEST:
            raise TrajectoryError(
                f"has {self.rows} rows, too few to compare", remedy=f"give more than {_FEWEST}", file=path
            )
        count, total, least, most = self._steps
        step = total / count
        return step, max(step - least, most - step) < _EVEN * step


def measured_torques(block: Trajectory, model: Model) -> Floats:
    """Return (k, n) the measured torques of a block of a log, zero where nothing is measured [N m]."""
    zero = np.zeros(len(block))
    return np.stack([block.extra.get(f"tau_{name}", zero) for name in model.rates], axis=1)
