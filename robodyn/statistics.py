"""What a motion loads each joint with, gathered block by block in bounded memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

COMPONENTS = ("fx", "fy", "fz", "mx", "my", "mz")
"""Of a wrench, in the order of its columns."""


@dataclass
class Peak:
    """The values of largest magnitude of several columns, and the samples where they are."""

    value: Floats
    index: NDArray[np.int64]

    @classmethod
    def of(cls, columns: int) -> Peak:
        return cls(np.zeros(columns), np.full(columns, -1))

    def update(self, values: Floats, first: int) -> list[tuple[int, int]]:
        """Take in a block whose first sample has the index `first`.

        Returns:
            (column, row of the block) for every column that has a new peak.
        """
        rows = values.argmax(axis=0)
        lows = values.argmin(axis=0)
        columns = np.arange(values.shape[1])
        rows = np.where(np.abs(values[lows, columns]) > np.abs(values[rows, columns]), lows, rows)
        found = values[rows, columns]
        news = np.flatnonzero((self.index < 0) | (np.abs(found) > np.abs(self.value)))
        self.value[news], self.index[news] = found[news], rows[news] + first
        return [(int(column), int(rows[column])) for column in news]


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
            quantities: (N, columns) or (N,) integrands.
        """
        weights = np.zeros(len(after) + 1)
        weights[:-1] += after
        weights[1:] += after
        weights[0] += before
        for name, values in quantities.items():
            total = 0.5 * (weights @ values)
            if name in self._last:
                total = total + 0.5 * before * self._last[name]
            self.totals[name] = self.totals.get(name, 0.0) + total
            self._last[name] = values[-1].copy()


class Statistics:
    """Peaks and integrals of joint torques and the base wrench.

    Attributes:
        at_peak: for each joint the time and the state (q, qd, qdd, columns) of its peak torque.
    """

    def __init__(self, effort: Floats, velocity: Floats) -> None:
        """Args: effort, velocity: (joints,) limits, infinite where there is none."""
        n = len(effort)
        self.effort, self.velocity = effort, velocity
        self.samples, self.start, self.end = 0, 0.0, 0.0
        self.torque, self.speed, self.base = Peak.of(n), Peak.of(n), Peak.of(len(COMPONENTS))
        self.base_time = np.zeros(len(COMPONENTS))
        self.peak_speed, self.torque_at_speed = np.zeros(n), np.zeros(n)
        self.power_most, self.power_least = np.full(n, -np.inf), np.full(n, np.inf)
        self.q_min, self.q_max = np.full(n, np.inf), np.full(n, -np.inf)
        self.quadrature = 0.0
        self.integrals = Integrals()
        self.at_peak: dict[int, tuple[float, dict[str, Floats]]] = {}

    def update(
        self,
        time: Floats,
        q: Floats,
        qd: Floats,
        tau: Floats,
        base: Floats,
        net_power: Floats,
        state: dict[str, Floats],
    ) -> None:
        """Take in a block: time (N,), joint positions, speeds and torques (N, joints), base wrench (N, 6) as f, n,
        the power that goes into stored energy (N,), and the arrays from which a peak's state is kept."""
        before = float(time[0] - self.end) if self.samples else 0.0
        steps = np.diff(time)
        self.start = self.start if self.samples else float(time[0])
        for joint, row in self.torque.update(tau, self.samples):
            self.peak_speed[joint] = qd[row, joint]
            self.at_peak[joint] = (float(time[row]), {name: values[row].copy() for name, values in state.items()})
        for joint, row in self.speed.update(qd, self.samples):
            self.torque_at_speed[joint] = tau[row, joint]
        for component, row in self.base.update(base, self.samples):
            self.base_time[component] = time[row]
        power, square = tau * qd, tau * tau
        np.maximum(self.power_most, power.max(axis=0), out=self.power_most)
        np.minimum(self.power_least, power.min(axis=0), out=self.power_least)
        np.minimum(self.q_min, q.min(axis=0), out=self.q_min)
        np.maximum(self.q_max, q.max(axis=0), out=self.q_max)
        self.integrals.update(
            before,
            steps,
            {
                "torque": tau,
                "square": square,
                "wear": square * np.abs(power),
                "travel": np.abs(qd),
                "positive": np.maximum(power, 0.0),
                "negative": np.minimum(power, 0.0),
                "base square": base * base,
                "net power": net_power,
                "turnover": np.abs(net_power),
                "over effort": (np.abs(tau) > self.effort).astype(float),
                "over velocity": (np.abs(qd) > self.velocity).astype(float),
            },
        )
        self.quadrature += quadrature_error(steps, net_power)
        self.samples += len(time)
        self.end = float(time[-1])

    @property
    def duration(self) -> float:
        return self.end - self.start

    def mean(self, name: str, single: Floats) -> Floats:
        """The time average of a quantity; `single` for a motion without duration."""
        return self.integrals.totals[name] / self.duration if self.duration > 0 else single


def quadrature_error(steps: Floats, values: Floats) -> float:
    """The error of the trapezoidal rule over one block, from the same rule with every second sample: (T_h - T_2h) / 3.

    Args:
        steps: (N - 1,) s; values: (N,).
    """
    pairs = len(steps) // 2
    left, right = steps[0 : 2 * pairs : 2], steps[1 : 2 * pairs : 2]
    a, b, c = values[0 : 2 * pairs : 2], values[1 : 2 * pairs : 2], values[2 : 2 * pairs + 1 : 2]
    fine = 0.5 * (left * (a + b) + right * (b + c))
    coarse = 0.5 * (left + right) * (a + c)
    return float(np.sum(fine - coarse)) / 3.0
