"""Self-checks along a motion, block by block: the laws at some samples, and work done against the energy stored."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from math import hypot, sqrt

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.balance import LawResiduals, energy, laws, losses
from robodyn.dynamics.effects.effect import ZeroColumns
from robodyn.dynamics.plan import Plan, plan, runner_of
from robodyn.loads.result import Checks, EnergyBalance
from robodyn.programs.run.runner import Run, Runner
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats, first_largest
from robodyn.support.sums import einsum
from robodyn.trajectory.motion import Trajectory

CHECKED_PER_BLOCK = 64
"""Samples of each block at which the laws are checked, evenly spread."""
Execute = Callable[[Runner, Mapping[str, Floats], int], Run]
"""Runs a program over sources, which are part of so many samples."""


@lru_cache(maxsize=16)
def _runners(a_plan: Plan) -> tuple[Runner, ...]:
    return tuple(runner_of(check(a_plan), a_plan) for check in (losses, laws, energy))


class SelfChecks:
    """Gathers `Checks`, block by block."""

    def __init__(self, model: Model, scene: Scene, borne: bool) -> None:
        """Args: borne: whether the weight balances at least, besides the bodies' momenta."""
        self.model, self.scene, self.ledger = model, scene, EnergyLedger()
        weight = model.total_mass * hypot(*scene.gravity) if borne else 0.0
        self.laws, self._checked = LawResiduals((weight, weight * model.reach)), 0

    def take(
        self,
        block: Trajectory,
        sources: Mapping[str, Floats],
        zero: ZeroColumns,
        tau: Floats,
        base: Floats,
        execute: Execute,
        whole: int,
    ) -> tuple[NDArray[np.int64], Floats]:
        """Take in a block; return the samples at which energy is computed, and there what `EnergyLedger.update` does.

        Args:
            zero: sources that are zero throughout. tau, base: (N, n), (N, 6). whole: samples of the motion.
        """
        rows = np.linspace(0, len(block) - 1, min(len(block), CHECKED_PER_BLOCK)).astype(int)
        self._checked = self._checked or -(-whole * len(rows) // len(block))
        lost, lawful, stored = _runners(plan(self.model, self.scene, zero))
        net = einsum("ij,ij->i", tau, block.qd) - execute(lost, sources, whole).values[:, 0]
        checked = {name: values[rows] for name, values in sources.items()}
        expected = execute(lawful, checked, self._checked).values
        self.laws.update(expected, base[rows], net[rows], tau[rows] * block.qd[rows])
        return rows, self.ledger.update(block.time, net, rows, execute(stored, checked, self._checked).values[:, 0])

    def report(self) -> Checks:
        force, moment = self.laws.largest
        largest = force, max(moment, force * self.model.reach)
        return Checks(self.ledger.balance, *self.laws.relative, self.laws.samples, *largest)


class EnergyLedger:
    """Trapezoidal integrals of the power that goes into stored energy, and how far the energy itself is from them."""

    def __init__(self) -> None:
        self.work = self.turnover = 0.0
        self._quadrature = self._quadrature_most = self._squares = 0.0
        self._energies: list[float] = []
        self._worst = self._stored_most = 0.0
        self._before: tuple[float, float] | None = None

    def update(self, time: Floats, power: Floats, rows: NDArray[np.int64], energy: Floats) -> Floats:
        """Take in a block; return (2, k) work done and energy stored since the start [J].

        Args:
            power: (N,) into stored energy [W].
            rows: (k,) samples, the first and the last among them, at which `energy` (k,) is given [J].
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
        change = self._energies[-1] - self._energies[0]
        largest = (self._worst, self._quadrature_most, sqrt(self._squares), self._stored_most)
        return EnergyBalance(self.work, change, self._quadrature, self.turnover, *largest)


def quadrature_errors(steps: Floats, values: Floats) -> Floats:
    """The error of the trapezoidal rule over each pair of steps (N - 1,) with values (N,): (T_h - T_2h) / 3."""
    pairs = len(steps) // 2
    left, right = steps[0 : 2 * pairs : 2], steps[1 : 2 * pairs : 2]
    a, b, c = values[0 : 2 * pairs : 2], values[1 : 2 * pairs : 2], values[2 : 2 * pairs + 1 : 2]
    fine = 0.5 * (left * (a + b) + right * (b + c))
    return (fine - 0.5 * (left + right) * (a + c)) / 3.0
