"""Error bars beside the loads of a motion: derivatives, block by block."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from robodyn.dynamics.effects.effect import ZeroColumns
from robodyn.dynamics.uncertain_parameters import misfits
from robodyn.loads.result import JointLoad
from robodyn.loads.sizing_result import Sizing
from robodyn.loads.uncertain_report import uncertain
from robodyn.loads.uncertainty import Pass, UncertaintyPass
from robodyn.loads.uncertainty_result import Uncertain
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
from robodyn.support.wording import shown
from robodyn.trajectory.motion import Trajectory

if TYPE_CHECKING:
    from robodyn.loads.sizing import SizingPass


class UncertainLoads:
    """Gathers what `Uncertain` tells, block by block.

    Attributes:
        notes: warnings.
    """

    def __init__(
        self,
        model: Model,
        scene: Scene,
        rates: slice,
        sizing: SizingPass | None,
        by: tuple[str, int | None],
    ) -> None:
        """Args: by: executor and threads."""
        trains = list(zip(sizing.driven, sizing.motors.trains, strict=True)) if sizing else []
        self.rates, self.by, self.notes = rates, by, (*misfits(model, scene), *_beyond(scene))
        self.linear = UncertaintyPass(model, scene, rates, trains, sizing is not None)

    def take(
        self,
        block: Trajectory,
        sources: Mapping[str, Floats],
        loads: Floats,
        off: Floats | float,
        zero: ZeroColumns,
        expected: int,
    ) -> None:
        """Take in a block; see `UncertaintyPass.take`. loads: perhaps with joints' wrenches that are not needed."""
        qd, qdd = (np.ascontiguousarray(each[:, self.rates].T) for each in (block.qd, block.qdd))
        self.linear.take(block.time, block.first_row, sources, loads, (qd, qdd), off, Pass(*self.by, expected), zero)

    def report(self, joints: Sequence[JointLoad], sizing: Sizing | None) -> Uncertain:
        """Return everything gathered."""
        return uncertain(self.linear, joints, sizing)


GROWING = 0.1
"""Friction that grows with load more than this may put error bars off by more than 5 %."""


def _beyond(scene: Scene) -> tuple[str, ...]:
    """Return a warning where friction may change sides, which error bars do not follow."""
    names = [name for name in scene.loaded if scene.friction[name].load > GROWING]
    if not names:
        return ()
    what = f"friction of {', '.join(map(shown, names))} grows with more than {100 * GROWING:.3g} % of the load"
    return (f"{what}: where that load is about zero, error bars may be off by more than 5 %",)
