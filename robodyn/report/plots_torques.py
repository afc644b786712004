"""The figures of a report on torques, begun before the rest of the report and there when it asks for them."""

from __future__ import annotations

import os

from robodyn.history import History
from robodyn.model import Model
from robodyn.report.document import Figure
from robodyn.report.drawing import PROCESSES, Draw, at_once
from robodyn.report.limits_words import effort_use, worst_joint
from robodyn.report.table import printable
from robodyn.result import Result

PLOTTED = 12
"""Joints that have plots; the most loaded of them where there are more."""


class Plots:
    """The figures that are drawn from the course of the motion: begun here, and there when they are asked for.

    Attributes:
        shown: the joints with plots; loaded: those whose shares are drawn.
        worst, when: the joint that is loaded most, and its moment.
    """

    def __init__(self, result: Result, history: History, model: Model, draw: Draw) -> None:
        from robodyn.report import figures_torques as figures

        joints = result.joints
        order = sorted(range(len(joints)), key=lambda k: (-effort_use(joints[k]), k))
        self.history, self.shown = history, sorted(order[:PLOTTED])
        self.worst = worst_joint(result)
        chunks = [self.shown[k::PROCESSES] for k in range(PROCESSES)]
        if self.worst is not None:
            joint = joints[self.worst]
            self.when = f"the peak of {printable(joint.name)}, {joint.peak_time:.6g} s"
            pose = (history.states[self.worst]["q"], joint.name, self.when)
            if draw is not at_once and os.path.isfile(model.file):
                self.picture = draw(figures.pose_figure, (model.file, model.floating), *pose)
            else:
                self.picture = at_once(figures.pose_figure, model, *pose)
        if history.joints is not None:
            self._joints = [draw(figures.joint_figures, joints, history.joints, chunk) for chunk in chunks]
        loaded = [joints[k] for k in sorted(order[: 2 * PLOTTED]) if joints[k].peak]
        self.shares = draw(figures.share_figure, loaded) if loaded else None
        self.base = draw(figures.base_figures, result.base_wrench, history)
        self.energy = draw(figures.energy_figure, result.checks.energy_balance, history)

    def joints(self) -> list[Figure]:
        """Those of the joints that are shown, in their order."""
        drawn = [figure for chunk in self._joints for figure in chunk()]
        order = [k for first in range(PROCESSES) for k in self.shown[first::PROCESSES]]
        return [drawn[order.index(k)] for k in self.shown]
