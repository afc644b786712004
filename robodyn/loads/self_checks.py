"""Self-checks along a motion: the laws at some samples of each block, the balance of energy over all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from math import hypot

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.balance import LawResiduals, energy, laws, losses
from robodyn.dynamics.effects.effect import ZeroColumns
from robodyn.dynamics.plan import Plan, plan
from robodyn.dynamics.runners import runner_of
from robodyn.loads.checks_result import Checks
from robodyn.loads.energy import EnergyLedger
from robodyn.programs.run.runner import Run, Runner
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
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
        """Take in a block; return the samples at which energy is computed, and there (2, rows) work done and energy
        stored since the start [J].

        Args:
            zero: sources that are zero throughout. tau, base: (N, n), (N, 6). whole: samples of the motion.
        """
        rows = np.linspace(0, len(block) - 1, min(len(block), CHECKED_PER_BLOCK)).astype(int)
        self._checked = self._checked or -(-whole * len(rows) // len(block))
        lost, lawful, stored = _runners(plan(self.model, self.scene, zero))
        net = np.einsum("ij,ij->i", tau, block.qd) - execute(lost, sources, whole).values[:, 0]
        checked = {name: values[rows] for name, values in sources.items()}
        expected = execute(lawful, checked, self._checked).values
        self.laws.update(expected, base[rows], net[rows], tau[rows] * block.qd[rows])
        return rows, self.ledger.update(block.time, net, rows, execute(stored, checked, self._checked).values[:, 0])

    def report(self) -> Checks:
        """Return everything gathered."""
        force, moment = self.laws.largest
        largest = force, max(moment, force * self.model.reach)
        return Checks(self.ledger.balance, *self.laws.relative, self.laws.samples, *largest)
