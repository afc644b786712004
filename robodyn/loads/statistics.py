"""Peaks, extremes and integrals along a motion, gathered block by block in bounded memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import BEYOND, Floats, first_of_ties, steady
from robodyn.trajectory.columns import COMPONENTS


class Extremes:
    """Where each of some columns is smallest and largest; of ties the first counts.

    Attributes:
        least, greatest: (k,) values.
        least_time, greatest_time: (k,) when [s].
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        k = len(self.names)
        self.least, self.greatest = np.full(k, np.inf), np.full(k, -np.inf)
        self.least_time, self.greatest_time = np.zeros(k), np.zeros(k)

    def update(self, time: Floats, values: Floats) -> None:
        """Take in a block: time (N,) and values (N, k), N > 0."""
        columns = np.arange(len(self.names))
        low, high = first_of_ties(-values.T), first_of_ties(values.T)
        lower = steady(values[low, columns]) < steady(self.least)
        higher = steady(values[high, columns]) > steady(self.greatest)
        self.least = np.where(lower, values[low, columns], self.least)
        self.least_time = np.where(lower, time[low], self.least_time)
        self.greatest = np.where(higher, values[high, columns], self.greatest)
        self.greatest_time = np.where(higher, time[high], self.greatest_time)


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

    def update(self, time: Floats, first_row: int, score: Floats, **values: Floats) -> None:
        """Take in a block: time (N,), score and further values (k, N), N > 0."""
        columns = np.arange(len(score))
        at = first_of_ties(score)
        new = steady(score[columns, at]) > steady(self.score)
        self.score = np.where(new, score[columns, at], self.score)
        self.time = np.where(new, time[at], self.time)
        self.row = np.where(new, at + first_row, self.row)
        for name, of in values.items():
            self.kept[name] = np.where(new, of[columns, at], self.kept.get(name, 0.0))


FOUNDATION = (*COMPONENTS, "fxy", "mxy")
"""Of the base wrench in reports: its components, and the resultants in the ground's plane that foundations bear."""


def resultant(x: Floats, y: Floats) -> Floats:
    """sqrt(x^2 + y^2), every step of which is rounded alike on all processors."""
    return np.asarray(np.sqrt(x * x + y * y))


@dataclass
class Peak:
    """The values of largest magnitude of several columns, and the samples where they are; of ties the first counts.

    Attributes:
        sure: the magnitudes less what they may be off by, which decide; most: the largest that any magnitude may be.
    """

    value: Floats
    sure: Floats
    most: Floats
    index: NDArray[np.int64]

    @classmethod
    def of(cls, columns: int) -> Peak:
        return cls(np.zeros(columns), np.full(columns, -np.inf), np.zeros(columns), np.full(columns, -1))

    def update(self, values: Floats, first: int, off: Floats | float = 0.0) -> list[tuple[int, int]]:
        """Take in a block (columns, N) whose first sample has the index `first`, and by how much it may be off.

        Returns:
            (column, sample of the block) for every column that has a new peak.
        """
        columns = np.arange(len(values))
        sure = np.abs(values) - off
        np.maximum(self.most, (np.abs(values) + off).max(axis=1), out=self.most)
        at = first_of_ties(sure)
        found = sure[columns, at]
        news = np.flatnonzero((self.index < 0) | (steady(found) > steady(self.sure)))
        self.value[news], self.sure[news], self.index[news] = values[news, at[news]], found[news], at[news] + first
        return [(int(column), int(at[column])) for column in news]


class Integrals:
    """Trapezoidal integrals over time of several quantities, across blocks."""

    def __init__(self) -> None:
        self.totals: dict[str, Floats] = {}
        self._last: dict[str, Floats] = {}

    def update(self, before: float, after: Floats, quantities: dict[str, Floats]) -> None:
        """Add a block.

        Args:
            before: time between the last sample of the previous block and the first of this one, 0 for the first block.
            after: (N - 1,) times between the samples of this block.
            quantities: (columns, N) or (N,) integrands.
        """
        weights = np.zeros(len(after) + 1)
        weights[:-1] += after
        weights[1:] += after
        weights[0] += before
        for name, values in quantities.items():
            total = 0.5 * np.einsum("...k,k->...", values, weights)
            if name in self._last:
                total = total + 0.5 * before * self._last[name]
            self.totals[name] = self.totals.get(name, 0.0) + total
            self._last[name] = values[..., -1].copy()


class Statistics:
    """Peaks and integrals of joint torques and the base wrench.

    Attributes:
        at_peak: for each joint the time and the state (q, qd, qdd, columns) of its peak torque.
    """

    def __init__(self, effort: Floats, velocity: Floats) -> None:
        """Args: effort, velocity: (joints,) limits, infinite where there is none."""
        n = len(effort)
        self.effort, self.velocity = effort, velocity
        self._most = BEYOND * np.array((effort, velocity))[..., None]
        self.samples, self.start, self.end = 0, 0.0, 0.0
        self.torque, self.speed, self.base = Peak.of(n), Peak.of(n), Peak.of(len(FOUNDATION))
        self.base_time = np.zeros(len(FOUNDATION))
        self.peak_speed, self.torque_at_speed, self.speed_time = np.zeros(n), np.zeros(n), np.zeros(n)
        self.power_most, self.power_least = np.full(n, -np.inf), np.full(n, np.inf)
        self.q_min, self.q_max = np.full(n, np.inf), np.full(n, -np.inf)
        self.integrals = Integrals()
        self.at_peak: dict[int, tuple[float, dict[str, Floats]]] = {}

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
            off: (joints, N) by how much torques may be off, about; a peak is where most of a torque is sure.
        """
        base = np.vstack((base, resultant(base[0], base[1]), resultant(base[3], base[4])))
        before = float(time[0] - self.end) if self.samples else 0.0
        steps = np.diff(time)
        self.start = self.start if self.samples else float(time[0])
        for joint, at in self.torque.update(tau, self.samples, off):
            self.peak_speed[joint] = qd[joint, at]
            self.at_peak[joint] = (float(time[at]), {name: values[at].copy() for name, values in state.items()})
        for joint, at in self.speed.update(qd, self.samples):
            self.torque_at_speed[joint], self.speed_time[joint] = tau[joint, at], time[at]
        for component, at in self.base.update(base, self.samples):
            self.base_time[component] = time[at]
        power, square, speed = tau * qd, tau * tau, np.abs(qd)
        np.maximum(self.power_most, power.max(axis=1), out=self.power_most)
        np.minimum(self.power_least, power.min(axis=1), out=self.power_least)
        np.minimum(self.q_min, q.min(axis=1), out=self.q_min)
        np.maximum(self.q_max, q.max(axis=1), out=self.q_max)
        self.integrals.update(
            before,
            steps,
            {
                "torque": tau,
                "square": square,
                "wear": square * np.abs(power),
                "travel": speed,
                "positive": np.maximum(power, 0.0),
                "negative": np.minimum(power, 0.0),
                "base square": base * base,
                "over effort": (np.abs(tau) > self._most[0]).astype(float),
                "over velocity": (speed > self._most[1]).astype(float),
            },
        )
        self.samples += len(time)
        self.end = float(time[-1])

    @property
    def duration(self) -> float:
        return self.end - self.start

    def mean(self, name: str, single: Floats) -> Floats:
        """The time average of a quantity; `single` for a motion without duration."""
        return self.integrals.totals[name] / self.duration if self.duration > 0 else single
