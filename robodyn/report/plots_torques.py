"""The figures of a report on torques, begun before the rest of the report and there when it asks for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from robodyn.loads.history import Curves, History
from robodyn.loads.result import JointLoad, Result
from robodyn.report.document import Figure
from robodyn.report.drawing import PROCESSES, Draw, Task
from robodyn.report.limits_words import effort_use, offenders, worst_joint
from robodyn.report.sizes import Sizes, result_sizes, speed_unit
from robodyn.report.table import NOISE, is_noise, printable
from robodyn.robot.model import Model
from robodyn.support.floats import ranked

PLOTTED = 12
"""Joints that have plots: those beyond limits, and the most loaded of the others up to so many."""


class Plots:
    """The figures that are drawn from the course of the motion: begun here, and there when they are asked for.

    Attributes:
        history: of the motion, with zeros for rounding noise.
        shown: the joints with plots; still: those that neither move nor carry anything, and have none.
        worst, when: the joint that is loaded most, and its moment.
    """

    def __init__(self, result: Result, history: History, model: Model, draw: Draw) -> None:
        from robodyn.report import figures_torques as figures

        joints, size = result.joints, result_sizes(result)
        self.history = history = _without_noise(history, joints, size)
        over = offenders(result)
        order = sorted(
            ranked(range(len(joints)), key=lambda k: effort_use(joints[k])), key=lambda k: joints[k].name not in over
        )
        self.still = [k for k in order if _rests(joints[k], size)]
        moving = [k for k in order if k not in self.still]
        self.shown = _in_order(moving[: max(PLOTTED, len(over))], over, joints)
        self.worst = worst_joint(result)
        tasks: dict[str, Task] = {}
        if history.joints is not None:
            for part in range(PROCESSES):
                chunk = self.shown[part::PROCESSES]
                tasks[f"joints {part}"] = partial(figures.joint_figures, joints, history.joints, chunk, size)
        if self.worst is not None:
            joint = joints[self.worst]
            self.when = f"the peak of {printable(joint.name)}, {joint.peak_time:.6g} s"
            assert model.description is not None, "it is not a model of bodies alone"
            pose = history.states[self.worst]["q"], joint.name, self.when
            tasks["picture"] = partial(figures.pose_figure, model.description, model.floating, *pose)
        loaded = [k for k in order if not is_noise(abs(joints[k].peak), size[joints[k].unit])]
        if loaded:
            shares = [joints[k] for k in _in_order(loaded, over, joints)]
            tasks["shares"] = partial(figures.share_figures, shares)
        tasks["base"] = partial(figures.base_figures, result.base_wrench, history, size)
        if history.energy.kept[:, 1].any():
            tasks["energy"] = partial(figures.energy_figure, result.checks.energy_balance, history, size)
        self._drawn = dict(zip(tasks, draw(list(tasks.values())), strict=True))

    def picture(self) -> tuple[Figure, str]:
        """The robot where its most loaded joint is loaded most, and what is said of shapes that are not there."""
        found: tuple[Figure, str] = self._drawn["picture"]()
        return found

    def shares(self) -> list[Figure]:
        """What each effect adds to the peaks; none where there are none."""
        return list(self._drawn["shares"]()) if "shares" in self._drawn else []

    def base(self) -> list[Figure]:
        """Forces and moments of the ground on the robot."""
        return list(self._drawn["base"]())

    def energy(self) -> list[Figure]:
        """Work and stored energy; nothing where both are zero throughout."""
        return [self._drawn["energy"]()] if "energy" in self._drawn else []

    def joints(self) -> list[Figure]:
        """Those of the joints that are shown, in their order."""
        drawn = [figure for part in range(PROCESSES) for figure in self._drawn[f"joints {part}"]()]
        order = [k for first in range(PROCESSES) for k in self.shown[first::PROCESSES]]
        return [drawn[order.index(k)] for k in self.shown]


def _in_order(columns: Sequence[int], over: frozenset[str], joints: Sequence[JointLoad]) -> list[int]:
    """Joints in the order of the robot, those beyond limits first."""
    return sorted(columns, key=lambda k: (joints[k].name not in over, k))


def _rests(joint: JointLoad, size: Sizes) -> bool:
    """Whether a joint neither moves nor carries anything."""
    return is_noise(abs(joint.peak), size[joint.unit]) and is_noise(abs(joint.max_speed), size[speed_unit(joint.unit)])


def _without_noise(history: History, loads: Sequence[JointLoad], size: Sizes) -> History:
    """The history with zeros for every quantity of which there is nothing but rounding noise."""
    units = [joint.unit for joint in loads]
    scales = {
        "speed": [size[speed_unit(unit)] for unit in units],
        "torque": [size[unit] for unit in units],
        "power": [size["W"] for _ in units],
    }
    base = [size["N" if name[0] == "f" else "N m"] for name in history.base.names]
    energy = [size["J"] for _ in history.energy.names]
    joints = history.joints and _quiet(history.joints, scales)
    return replace(
        history,
        joints=joints,
        base=_quiet(history.base, {"load": base}),
        energy=_quiet(history.energy, {"energy": energy}),
    )


def _quiet(curves: Curves, scales: Mapping[str, Sequence[float]]) -> Curves:
    """Curves with zeros where the values of a column are all noise beside its scale."""
    kept = curves.kept.copy()
    for k, quantity in enumerate(curves.quantities, start=1):
        if quantity in scales:
            kept[:, k, np.abs(kept[:, k]).max(axis=(0, 2)) <= NOISE * np.array(scales[quantity])] = 0.0
    return replace(curves, kept=kept)
