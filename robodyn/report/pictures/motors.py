"""Torque against speed at the shafts of motors, with their curves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from robodyn.loads.figures import joint_of_rates
from robodyn.loads.history import Curves
from robodyn.loads.motors import load_torque, motor_torque, train_of
from robodyn.loads.sizing_result import MotorLoad, Sizing
from robodyn.report.document import Figure
from robodyn.report.pictures.figures import BAD, SERIES, dots, few_ticks, plot
from robodyn.report.pictures.panels import WIDE, zero_lines
from robodyn.report.table import number, printable
from robodyn.robot.model import Model
from robodyn.scene.motor import Curve
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


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
