"""Work done on the robot against the energy it stores, along the motion and block by block."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robodyn.loads.checks_result import EnergyBalance
from robodyn.support.floats import Floats, first_largest


class EnergyLedger:
    """Trapezoidal integrals of the power that goes into stored energy, and how far the energy itself is from them."""

    def __init__(self) -> None:
        self.work = self.turnover = 0.0
        self._quadrature = self._quadrature_most = self._squares = 0.0
        self._energies: list[float] = []
        self._worst = self._stored_most = 0.0
        self._before: tuple[float, float] | None = None

    def update(self, time: Floats, power: Floats, rows: NDArray[np.int64], energy: Floats) -> Floats:
        """Take in a block.

        Args:
            time: (N,) s.
            power: (N,) power into stored energy [W].
            rows: (k,) samples, the first and the last among them, at which `energy` (k,) is given [J].

        Returns:
            (2, k) work done and energy stored since the start [J].
        """
        carried = 0 if self._before is None else 1
        if self._before is not None:
            time, power = np.append(self._before[0], time), np.append(self._before[1], power)
        steps = np.diff(time)
        work = self.work + np.append(0.0, np.cumsum(0.5 * steps * (power[1:] + power[:-1])))
        self.turnover += float(np.sum(0.5 * steps * (np.abs(power[1:]) + np.abs(power[:-1]))))
        self._energies = [*self._energies[:1], *energy.tolist()]
        done, stored = work[rows + carried], energy - self._energies[0]
        residual = done - stored
        found = [self._worst, *residual.tolist()]
        self._worst = found[first_largest(np.abs(found))]
        self._stored_most = max(self._stored_most, float(np.abs(energy).max()))
        parts = quadrature_errors(steps, power)
        self._squares += float(np.sum((3.0 * parts) ** 2))
        errors = self._quadrature + np.cumsum(parts)
        self._quadrature_most = max(self._quadrature_most, float(np.abs(errors).max(initial=0.0)))
        self._quadrature = float(errors[-1]) if len(errors) else self._quadrature
        self.work, self._before = float(work[-1]), (float(time[-1]), float(power[-1]))
        return np.stack((done, stored))

    @property
    def balance(self) -> EnergyBalance:
        """What has been gathered."""
        change = self._energies[-1] - self._energies[0]
        largest = (self._worst, self._quadrature_most, math.sqrt(self._squares), self._stored_most)
        return EnergyBalance(self.work, change, self._quadrature, self.turnover, *largest)


def quadrature_errors(steps: Floats, values: Floats) -> Floats:
    """The error of the trapezoidal rule over each pair of steps, from the rule over both at once: (T_h - T_2h) / 3.

    Args:
        steps: (N - 1,) s; values: (N,).

    Returns:
        ((N - 1) // 2,).
    """
    pairs = len(steps) // 2
    left, right = steps[0 : 2 * pairs : 2], steps[1 : 2 * pairs : 2]
    a, b, c = values[0 : 2 * pairs : 2], values[1 : 2 * pairs : 2], values[2 : 2 * pairs + 1 : 2]
    fine = 0.5 * (left * (a + b) + right * (b + c))
    return (fine - 0.5 * (left + right) * (a + c)) / 3.0
