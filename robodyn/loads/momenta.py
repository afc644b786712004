"""Momentum, energy and power of each block of a trajectory, and their extremes along all of it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robodyn.dynamics.effects.effect import ZeroColumns
from robodyn.dynamics.momenta import COLUMNS, View, momentum_runner
from robodyn.dynamics.plan import plan
from robodyn.loads.result import MomentumReport
from robodyn.loads.statistics import Extremes, check_loads
from robodyn.programs.run.runner import Runner
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum
from robodyn.trajectory.motion import Trajectory

NAMES = (*COLUMNS, "power")
"""Columns of momentum and energy, and the power tau . qd of the actuators and of what moves the base."""


class MomentumPass:
    """Gathers what `View` asks for, block by block."""

    def __init__(self, model: Model, scene: Scene, view: View, file: str | None) -> None:
        view.check(model, scene)
        self.model, self.scene, self.view, self.file = model, scene, view, file
        self.extremes = Extremes(NAMES)

    def take(self, block: Trajectory, tau: Floats, pattern: ZeroColumns, run: Callable[[Runner], Floats]) -> Floats:
        """Return the columns (N, 12) of one block, in which `pattern` is zero.

        Accelerations are not looked at, so that the energy of a rotor counts also in a block without any.
        """
        moving = frozenset(pair for pair in pattern if pair[0] != "qdd")
        found = run(momentum_runner(plan(self.model, self.scene, moving), self.view))
        columns = np.column_stack((found, einsum("ij,ij->i", tau, block.qd)))
        check_loads(columns, NAMES, block.first_row, self.file)
        self.extremes.update(block.time, columns)
        return columns

    def report(self) -> MomentumReport:
        return MomentumReport(self.view.about, self.view.frame, tuple(self.extremes.ranges()))
