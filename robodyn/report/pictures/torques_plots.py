"""Which figures a report on torques has, and of which joints; torque against speed at the shafts of motors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from robodyn.loads.history import Curves, History
from robodyn.loads.motors import load_torque, motor_torque, train_of
from robodyn.loads.result import JointLoad, Result
from robodyn.loads.sizing_result import MotorLoad, Sizing
from robodyn.loads.statistics import joint_of_rates
from robodyn.report.document import Figure
from robodyn.report.limits import effort_use, offenders, worst_joint
from robodyn.report.pictures.figures import BAD, SERIES, WIDE, dots, few_ticks, plot, zero_lines
from robodyn.report.pictures.torques import base_figures, contact_figures, energy_figure, joint_figure, share_figures
from robodyn.report.sizes import Sizes, result_sizes, speed_unit
from robodyn.report.table import NOISE, is_noise, number, printable
from robodyn.robot.model import Model
from robodyn.scene.parts import Curve
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats, ranked

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


PLOTTED = 12
"""Joints that have plots: those beyond limits, and the most loaded of the others up to so many."""


class Plots:
    """The figures that are drawn from the course of a motion; none without its history.

    Attributes:
        history: of the motion, with zeros for rounding noise.
        shown: the joints with plots; still: those that neither move nor carry anything, and have none.
        worst, when: the joint that is loaded most, and its moment.
    """

    def __init__(self, result: Result, history: History | None, model: Model) -> None:
        joints, size = result.joints, result_sizes(result)
        self._result, self._model, self._size = result, model, size
        self._over = over = offenders(result)
        self.history, self.worst, self.when = None, None, ""
        self.shown, self.still = list[int](), list[int]()
        if history is None:
            return
        self.history = _without_noise(history, joints, size)
        order = sorted(
            ranked(range(len(joints)), key=lambda k: effort_use(joints[k])), key=lambda k: joints[k].name not in over
        )
        self.still = [k for k in order if _rests(joints[k], size)]
        moving = [k for k in order if k not in self.still]
        self.shown = _in_order(moving[: max(PLOTTED, len(over))], over, joints)
        self.worst = worst_joint(result)
        if self.worst is not None:
            joint = joints[self.worst]
            self.when = f"the peak of {printable(joint.name)}, {joint.peak_time:.6g} s"

    def picture(self) -> tuple[Figure, str]:
        """Return the robot where its most loaded joint is loaded most, and a sentence on shapes that are missing."""
        from robodyn.report.pictures.robot import robot_figure, shapes_of

        assert self.history is not None
        assert self.worst is not None, "there are joints"
        shapes, why = shapes_of(self._model)
        q, name = self.history.states[self.worst]["q"], self._result.joints[self.worst].name
        return robot_figure(self._model, q, name, self.when, shapes), why

    def shares(self) -> list[Figure]:
        """Return what each effect adds to the peaks; nothing where there are none."""
        if self.history is None:
            return []
        joints, size = self._result.joints, self._size
        loaded = [k for k, joint in enumerate(joints) if not is_noise(abs(joint.peak), size[joint.unit])]
        return share_figures([joints[k] for k in _in_order(loaded, self._over, joints)]) if loaded else []

    def base(self) -> list[Figure]:
        """Return forces and moments of the ground on the robot."""
        return base_figures(self._result.base_wrench, self.history, self._size) if self.history else []

    def contacts(self) -> list[Figure]:
        """Return what each contact presses with; nothing without contacts."""
        found, history = self._result.constraints, self.history
        known = found and history and history.contacts
        return contact_figures(found.contacts, known, self._size) if found and known else []

    def energy(self) -> list[Figure]:
        """Return work and stored energy; nothing where both are zero throughout."""
        if self.history is None or not self.history.energy.kept[:, 1].any():
            return []
        return [energy_figure(self._result.checks.energy_balance, self.history, self._size)]

    def joints(self) -> list[Figure]:
        """Return the figures of the joints that are shown, in their order."""
        curves = self.history and self.history.joints
        return [joint_figure(self._result.joints[k], curves, k, self._size) for k in self.shown] if curves else []


def _in_order(columns: Sequence[int], over: frozenset[str], joints: Sequence[JointLoad]) -> list[int]:
    """Return joints in the order of the robot, those beyond limits first."""
    return sorted(columns, key=lambda k: (joints[k].name not in over, k))


def _rests(joint: JointLoad, size: Sizes) -> bool:
    """Return whether a joint neither moves nor carries anything."""
    return is_noise(abs(joint.peak), size[joint.unit]) and is_noise(abs(joint.max_speed), size[speed_unit(joint.unit)])


def _without_noise(history: History, loads: Sequence[JointLoad], size: Sizes) -> History:
    """Return the history with zeros for every quantity of which there is nothing but rounding noise."""
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
    """Return curves with zeros where the values of a column are all noise beside its scale."""
    kept = curves.kept.copy()
    for k, quantity in enumerate(curves.quantities, start=1):
        if quantity in scales:
            kept[:, k, np.abs(kept[:, k]).max(axis=(0, 2)) <= NOISE * np.array(scales[quantity])] = 0.0
    return replace(curves, kept=kept)


def motor_figures(sizing: Sizing, model: Model, scene: Scene, curves: Curves) -> Iterator[tuple[str, Figure]]:
    """Yield for each joint with a motor torque against speed at its shaft, with its curves."""
    joints = joint_of_rates(model)[6 if model.floating else 0 :]
    for k, (joint, sized) in enumerate(zip(joints, sizing.joints, strict=True)):
        train = train_of(joint, scene)
        if train is None or sized.motor is None:
            continue
        samples = curves.samples(k)
        tau, qd, qdd = samples["torque"], samples["speed"], samples["acceleration"]
        torque = motor_torque(train, load_torque(train, tau, qdd), qd, qdd)
        yield sized.name, _figure(sized.name, sized.motor, train.gear * qd, torque, k)


def _figure(name: str, motor: MotorLoad, speed: Floats, torque: Floats, k: int) -> Figure:
    fastest = max(float(np.abs(speed).max()), motor.speed_limit or 0.0)

    def draw(canvas: Canvas) -> None:
        axes = canvas.add_axes((0.16, 0.1, 0.8, 0.74))
        for curve, colour, label in ((motor.peak_curve, BAD, "peak"), (motor.continuous, SERIES[1], "continuous")):
            if curve is not None:
                _envelope(axes, curve, fastest, colour, label)
        dots(axes, speed, torque, SERIES[0])
        axes.margins(0.06)
        zero_lines(axes)
        axes.set_title(f"torque [{motor.unit}] against speed [{motor.speed_unit}]", y=1.1)
        if motor.peak_curve or motor.continuous:
            axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, columnspacing=1.0)
        few_ticks(axes)

    alt = (
        f"Motor of {printable(name)}: peak torque {number(motor.peak)} {motor.unit}, largest speed "
        f"{number(motor.max_speed)} {motor.speed_unit}, RMS torque {number(motor.rms)} {motor.unit}, against its curves"
    )
    return Figure(f"Motor of {printable(name)}", alt, plot(WIDE, 320, draw, f"motor {k}"))


def _envelope(axes: Axes, curve: Curve, fastest: float, colour: str, label: str) -> None:
    """Draw a curve of magnitudes in all four quadrants."""
    speeds, torques = (list(each) for each in zip(*curve, strict=True))
    if len(speeds) == 1:
        speeds, torques = [0.0, fastest], [torques[0]] * 2
    else:
        speeds, torques = [0.0, *speeds, speeds[-1]], [torques[0], *torques, 0.0]
    for across in (1.0, -1.0):
        for up in (1.0, -1.0):
            x, y = [across * w for w in speeds], [up * t for t in torques]
            first = across == up == 1.0
            axes.plot(x, y, color=colour, linewidth=1.2, dashes=(5, 3), label=label if first else None)
