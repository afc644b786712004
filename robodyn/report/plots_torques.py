"""The figures of a report on torques, begun before the rest of the report and there when it asks for them."""

from __future__ import annotations

from functools import partial

from robodyn.history import History
from robodyn.model import Model
from robodyn.report.document import Figure
from robodyn.report.drawing import PROCESSES, Draw, Task
from robodyn.report.limits_words import effort_use, worst_joint
from robodyn.report.table import printable
from robodyn.result import Result

PLOTTED = 12
"""Joints that have plots; the most loaded of them where there are more."""


class Plots:
    """The figures that are drawn from the course of the motion: begun here, and there when they are asked for.

    Attributes:
        history: of the motion; shown: the joints with plots.
        worst, when: the joint that is loaded most, and its moment.
    """

    def __init__(self, result: Result, history: History, model: Model, draw: Draw) -> None:
        from robodyn.report import figures_torques as figures

        joints = result.joints
        order = sorted(range(len(joints)), key=lambda k: (-effort_use(joints[k]), k))
        self.history, self.shown = history, sorted(order[:PLOTTED])
        self.worst = worst_joint(result)
        tasks: dict[str, Task] = {}
        if history.joints is not None:
            for part in range(PROCESSES):
                chunk = self.shown[part::PROCESSES]
                tasks[f"joints {part}"] = partial(figures.joint_figures, joints, history.joints, chunk)
        if self.worst is not None:
            joint = joints[self.worst]
            self.when = f"the peak of {printable(joint.name)}, {joint.peak_time:.6g} s"
            assert model.description is not None, "it is not a model of bodies alone"
            pose = history.states[self.worst]["q"], joint.name, self.when
            tasks["picture"] = partial(figures.pose_figure, model.description, model.floating, *pose)
        loaded = [joints[k] for k in sorted(order[: 2 * PLOTTED]) if joints[k].peak]
        if loaded:
            tasks["shares"] = partial(figures.share_figure, loaded)
        tasks["base"] = partial(figures.base_figures, result.base_wrench, history)
        tasks["energy"] = partial(figures.energy_figure, result.checks.energy_balance, history)
        self._drawn = dict(zip(tasks, draw(list(tasks.values())), strict=True))

    def picture(self) -> tuple[Figure, str]:
        """The robot where its most loaded joint is loaded most, and what is said of shapes that are not there."""
        found: tuple[Figure, str] = self._drawn["picture"]()
        return found

    def shares(self) -> list[Figure]:
        """What each effect adds to the peaks; none where there are none."""
        return [self._drawn["shares"]()] if "shares" in self._drawn else []

    def base(self) -> list[Figure]:
        """Forces and moments of the ground on the robot."""
        return list(self._drawn["base"]())

    def energy(self) -> Figure:
        """Work and stored energy."""
        found: Figure = self._drawn["energy"]()
        return found

    def joints(self) -> list[Figure]:
        """Those of the joints that are shown, in their order."""
        drawn = [figure for part in range(PROCESSES) for figure in self._drawn[f"joints {part}"]()]
        order = [k for first in range(PROCESSES) for k in self.shown[first::PROCESSES]]
        return [drawn[order.index(k)] for k in self.shown]
