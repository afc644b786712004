"""Joints and energies of a simulated motion, and measured against computed torques, as plots."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from robodyn.identification.faults.compare import Comparison
from robodyn.loads.history import MinMaxDecimation
from robodyn.report.document import Figure
from robodyn.report.pictures.figures import BAD, SERIES, WIDE, Line, dots, lines_figure, panel, plot, quiet, zero_lines
from robodyn.report.sizes import simulation_sizes
from robodyn.report.table import NOISE, drift_text, number, printable
from robodyn.simulation.result import Simulation
from robodyn.support.floats import Floats

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

_POINTS = 1500
"""Of a line of a log."""


def _line(time: Floats, values: Floats) -> Line:
    """Return the least and the greatest of every short span of time."""
    thinned = MinMaxDecimation(("",), ("value",))
    thinned.update(time, (values[None],), float(time[-1] - time[0]))
    return thinned.curves().line("value", 0)


def joint_figure(name: str, slides: bool, time: Floats, values: tuple[Floats, ...]) -> Figure:
    """Return position, speed and load of a joint against time, without what is zero throughout."""
    units = ("m", "m/s", "N") if slides else ("rad", "rad/s", "N m")
    what = ("position", "speed", "drive's force" if slides else "drive's torque")
    shown = [k for k in range(len(what)) if values[k].any()]
    height = 130 * len(shown) + 20

    def draw(canvas: Canvas) -> None:
        for row, k in enumerate(shown, start=1):
            axes = panel(canvas, height - 130 * row + 12, 96)
            axes.plot(*_line(time, values[k]), color=SERIES[k])
            axes.set_title(f"{what[k]} [{units[k]}]")
            axes.tick_params(labelbottom=row == len(shown))
        axes.set_xlabel("time [s]", labelpad=1)

    ranges = [f"{what[k]} {number(values[k].min())} to {number(values[k].max())} {units[k]}" for k in shown]
    alt = f"Joint {printable(name)} against time: {', '.join(ranges)}"
    return Figure(printable(name), alt, plot(WIDE, height, draw, f"joint {name}"))


def energy_figures(result: Simulation) -> Iterator[Figure]:
    """Yield energies and work that are not zero throughout, and the drift where it is more than rounding."""
    figures, size, work = result.figures, simulation_sizes(result).energy, result.work - result.work[0]
    given = {"kinetic": figures.kinetic, "potential": figures.energy - figures.kinetic, "work done": work}
    parts = {name: _line(result.time, kept) for name, each in given.items() if (kept := quiet(each, size)).any()}
    if parts:
        largest = f"Against time; the largest kinetic energy is {number(figures.kinetic.max(), size)} J"
        yield lines_figure("Energies, and work done by drives and wrenches", largest, parts, "J")
    if result.energy_drift > NOISE * size:
        off = f"Stored energy less work done against time, at most {drift_text(result.energy_drift, size)} J from zero"
        drift = _line(result.time, figures.energy - figures.energy[0] - work)
        yield lines_figure("Drift: stored energy less work", off, {"drift": drift}, "J")


def torque_figure(found: Comparison, j: int) -> Figure:
    """Return measured and computed torque of a joint over time, and below what is left, before and after effects."""
    joint, curves = found.joints[j], found.curves
    every = slice(None, None, max(1, len(curves.time) // _POINTS))
    time, measured = curves.time[every], curves.measured[every, j]
    computed, explained = curves.computed[every, j], curves.explained[every, j]

    def draw(canvas: Canvas) -> None:
        above, below = panel(canvas, 205, 170), panel(canvas, 40, 115)
        lines = (("computed", computed, 1), ("with effects", explained, 2), ("measured", measured, 0))
        for label, line, colour in lines:
            above.plot(time, line, label=label, color=SERIES[colour], linewidth=1.0)
            if colour:
                below.plot(time, measured - line, color=SERIES[colour], linewidth=1.0)
        above.legend(loc="lower right", bbox_to_anchor=(1.0, 1.02), ncols=3, columnspacing=1.0)
        above.set_title(f"[{joint.unit}]")
        below.set(title=f"residuals [{joint.unit}]", xlabel="time [s]")

    alt = (
        f"{printable(joint.name)}: measured {number(joint.measured)} {joint.unit} RMS, "
        f"computed {number(joint.computed)}, residual {number(joint.residual)}, {number(joint.left)} with effects"
    )
    return Figure(printable(joint.name), alt, plot(WIDE, 420, draw, f"measured {j}"))


def friction_figure(found: Comparison, j: int) -> Figure:
    """Return over speed the friction that was told, and what of the measured torque nothing else explains."""
    joint, curves = found.joints[j], found.curves
    speed, told = curves.speed[:, j], curves.friction[:, j]

    def draw(canvas: Canvas) -> None:
        axes = panel(canvas, 45, 195)
        dots(axes, speed, (curves.measured - curves.explained + curves.friction)[:, j], SERIES[0])
        if told.any():
            dots(axes, speed, told, BAD)
        axes.margins(0.06)
        zero_lines(axes)
        axes.set_title(f"[{joint.unit}] over speed [{'rad/s' if joint.unit == 'N m' else 'm/s'}]")

    size = number(float(np.abs(told).max()))
    alt = f"Torque over speed of {printable(joint.name)}; friction that was told reaches {size} {joint.unit}"
    return Figure(printable(joint.name), alt, plot(WIDE, 280, draw, f"friction {j}"))
