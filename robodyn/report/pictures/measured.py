"""Plots of measured against computed torques, their residuals, and friction over speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from robodyn.identification.compare import Comparison
from robodyn.report.document import Figure
from robodyn.report.pictures.figures import BAD, SERIES, dots, few_ticks, plot
from robodyn.report.pictures.panels import WIDE, panel, zero_lines
from robodyn.report.table import number, printable

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

_MOST = 1500
"""Points of a line."""
_TALL = 420


def torque_figure(found: Comparison, j: int) -> Figure:
    """Return measured and computed torque of a joint over time, and below what is left, before and after effects."""
    joint, curves = found.joints[j], found.curves
    every = slice(None, None, max(1, len(curves.time) // _MOST))
    time, measured = curves.time[every], curves.measured[every, j]
    computed, explained = curves.computed[every, j], curves.explained[every, j]

    def draw(canvas: Canvas) -> None:
        above, below = panel(canvas, 205, 170, _TALL), panel(canvas, 40, 115, _TALL)
        lines = (("computed", computed, 1), ("with effects", explained, 2), ("measured", measured, 0))
        for label, line, colour in lines:
            above.plot(time, line, label=label, color=SERIES[colour], linewidth=1.0)
        above.legend(loc="lower right", bbox_to_anchor=(1.0, 1.02), ncols=3, columnspacing=1.0)
        above.set_title(f"[{joint.unit}]")
        below.plot(time, measured - computed, color=SERIES[1], linewidth=1.0)
        below.plot(time, measured - explained, color=SERIES[2], linewidth=1.0)
        below.set_title(f"residuals [{joint.unit}]")
        below.set_xlabel("time [s]")
        for axes in (above, below):
            few_ticks(axes)

    alt = (
        f"{printable(joint.name)}: measured {number(joint.measured)} {joint.unit} RMS, "
        f"computed {number(joint.computed)}, residual {number(joint.residual)}, {number(joint.left)} with effects"
    )
    return Figure(printable(joint.name), alt, plot(WIDE, _TALL, draw, f"measured {j}"))


def friction_figure(found: Comparison, j: int) -> Figure:
    """Return over speed the friction that was told, and what of the measured torque nothing else explains."""
    joint, curves = found.joints[j], found.curves
    every = slice(None, None, max(1, len(curves.time) // _MOST))
    speed, told = curves.speed[every, j], curves.friction[every, j]
    rest = (curves.measured - curves.explained + curves.friction)[every, j]

    def draw(canvas: Canvas) -> None:
        axes = canvas.add_axes((0.16, 0.16, 0.8, 0.7))
        dots(axes, speed, rest, SERIES[0], 2.0)
        if told.any():
            order = np.argsort(speed)
            dots(axes, speed[order], told[order], BAD, 2.0)
        axes.margins(0.06)
        zero_lines(axes)
        axes.set_title(f"[{joint.unit}] over speed [{'rad/s' if joint.unit == 'N m' else 'm/s'}]")
        few_ticks(axes)

    size = number(float(np.abs(told).max()))
    alt = f"Torque over speed of {printable(joint.name)}; friction that was told reaches {size} {joint.unit}"
    return Figure(printable(joint.name), alt, plot(WIDE, 280, draw, f"friction {j}"))
