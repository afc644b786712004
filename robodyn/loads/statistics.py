"""Peaks, extremes and integrals along a motion, gathered block by block in bounded memory."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robodyn.support.floats import BEYOND, Floats, first_of_ties, steady
from robodyn.support.sums import einsum
from robodyn.trajectory.columns.signals import COMPONENTS

FOUNDATION = (*COMPONENTS, "fxy", "mxy")
"""Of the base wrench in reports: its components, and the resultants in the ground's plane that foundations bear."""


def resultant(x: Floats, y: Floats) -> Floats:
    """sqrt(x^2 + y^2), every step of which is rounded alike on all processors."""
    return np.asarray(np.sqrt(x * x + y * y))


class Greatest:
    """For each of several columns the sample at which a score is greatest; of ties the first counts.

    Attributes:
        score: (k,) the greatest; time: (k,) when [s]; row: (k,) of the data, from 1.
        kept: by name (k,) what else was given of that sample.
    """

    def __init__(self, columns: int) -> None:
        self.score = np.full(columns, -np.inf)
        self.time, self.row = np.zeros(columns), np.zeros(columns, dtype=np.int64)
        self.kept: dict[str, Floats] = {}

    def update(self, time: Floats, first_row: int, score: Floats, **values: Floats) -> list[tuple[int, int]]:
        """Take in a block: time (N,), score and further values (k, N), N > 0.

        Returns:
            (column, sample of the block) for every column that has a new greatest.
        """
        columns = np.arange(len(score))
        at = first_of_ties(score)
        new = (self.row == 0) | (steady(score[columns, at]) > steady(self.score))
        self.score = np.where(new, score[columns, at], self.score)
        self.time = np.where(new, time[at], self.time)
        self.row = np.where(new, at + first_row, self.row)
        for name, of in values.items():
            self.kept[name] = np.where(new, of[columns, at], self.kept.get(name, 0.0))
        return [(int(column), int(at[column])) for column in np.flatnonzero(new)]


class Extremes:
    """Where each of some columns is smallest and largest; of ties the first counts."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self._low, self._high = Greatest(len(self.names)), Greatest(len(self.names))

    def update(self, time: Floats, values: Floats) -> None:
        """Take in a block: time (N,) and values (N, k), N > 0."""
        self._low.update(time, 1, -values.T)
        self._high.update(time, 1, values.T)

    @property
    def figures(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Of each column the least value, when [s], the greatest, when."""
        return -self._low.score, self._low.time, self._high.score, self._high.time


class Integrals:
    """Trapezoidal integrals over time of several quantities, across blocks.

    Attributes:
        samples, start, end: how many so far, and when the first and the last of them are [s].
    """

    def __init__(self) -> None:
        self.samples, self.start, self.end = 0, 0.0, 0.0
        self.totals: dict[str, Floats] = {}
        self._last: dict[str, Floats] = {}

    @property
    def duration(self) -> float:
        return self.end - self.start

    def update(self, time: Floats, quantities: dict[str, Floats]) -> None:
        """Add a block.

        Args:
            time: (N,) s, N > 0.
            quantities: (columns, N) or (N,) integrands.
        """
        before = float(time[0] - self.end) if self.samples else 0.0
        after, weights = np.diff(time), np.zeros(len(time))
        weights[:-1] += after
        weights[1:] += after
        weights[0] += before
        for name, values in quantities.items():
            total = 0.5 * einsum("...k,k->...", values, weights)
            if name in self._last:
                total = total + 0.5 * before * self._last[name]
            self.totals[name] = self.totals.get(name, 0.0) + total
            self._last[name] = values[..., -1].copy()
        self.start, self.end = self.start if self.samples else float(time[0]), float(time[-1])
        self.samples += len(time)

    def mean(self, name: str, single: Floats) -> Floats:
        """Return the time average of a quantity; `single` for a motion without duration."""
        return self.totals[name] / self.duration if self.duration > 0 else single


class Statistics:
    """Peaks and integrals of joint torques and the base wrench.

    Attributes:
        torque: by its magnitude, with its `value` and the `speed` then.
        least, most: (joints,) between which the largest magnitude is, as far as torques are sure.
        speed: by its magnitude, with its `value` and the `torque` then; base: likewise, with its `value`.
        at_peak: for each joint the state (q, qd, qdd, columns) of its peak torque.
    """

    def __init__(self, effort: Floats, velocity: Floats) -> None:
        """Args: effort, velocity: (joints,) limits, infinite where there is none."""
        n = len(effort)
        self._most = BEYOND * np.array((effort, velocity))[..., None]
        self.torque, self.speed, self.base = Greatest(n), Greatest(n), Greatest(len(FOUNDATION))
        self.least, self.most = np.zeros(n), np.zeros(n)
        self.power_most, self.power_least = np.full(n, -np.inf), np.full(n, np.inf)
        self.q_min, self.q_max = np.full(n, np.inf), np.full(n, -np.inf)
        self.integrals = Integrals()
        self.at_peak: dict[int, dict[str, Floats]] = {}

    def update(
        self,
        time: Floats,
        q: Floats,
        qd: Floats,
        tau: Floats,
        base: Floats,
        state: dict[str, Floats],
        off: Floats | float = 0.0,
    ) -> None:
        """Take in a block.

        Args:
            time: (N,) s.
            q, qd, tau: (joints, N).
            base: (6, N) base wrench f, n.
            state: (N, k) arrays of which a peak's sample is kept.
            off: (joints, N) by how much torques may be off.
        """
        base = np.vstack((base, resultant(base[0], base[1]), resultant(base[3], base[4])))
        row, size, speed = self.integrals.samples + 1, np.abs(tau), np.abs(qd)
        np.maximum(self.least, (size - off).max(axis=1), out=self.least)
        np.maximum(self.most, (size + off).max(axis=1), out=self.most)
        for joint, at in self.torque.update(time, row, size, value=tau, speed=qd):
            self.at_peak[joint] = {name: values[at].copy() for name, values in state.items()}
        self.speed.update(time, row, speed, value=qd, torque=tau)
        self.base.update(time, row, np.abs(base), value=base)
        power, square = tau * qd + 0.0, tau * tau  # no power is 0, and not -0
        np.maximum(self.power_most, power.max(axis=1), out=self.power_most)
        np.minimum(self.power_least, power.min(axis=1), out=self.power_least)
        np.minimum(self.q_min, q.min(axis=1), out=self.q_min)
        np.maximum(self.q_max, q.max(axis=1), out=self.q_max)
        self.integrals.update(
            time,
            {
                "torque": tau,
                "square": square,
                "wear": square * np.abs(power),
                "travel": speed,
                "positive": np.maximum(power, 0.0),
                "negative": np.minimum(power, 0.0),
                "base square": base * base,
                "over effort": (size > self._most[0]).astype(float),
                "over velocity": (speed > self._most[1]).astype(float),
            },
        )
