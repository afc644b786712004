"""Joints and energies of a simulated motion, and measured against computed torques, as plots."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from robodyn.identification.faults.compare import Comparison
from robodyn.loads.history import Curves, MinMaxDecimation
from robodyn.report.document import Figure
from robodyn.report.pictures.figures import (
    BAD,
    LOW,
    SERIES,
    WIDE,
    against_time,
    dots,
    few_ticks,
    panel,
    plot,
    zero_lines,
)
from robodyn.report.sizes import simulation_sizes
from robodyn.report.table import NOISE, drift_text, is_noise, number, printable
from robodyn.simulation.result import Simulation
from robodyn.support.floats import Floats

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas


def quiet(values: Floats, scale: float) -> Floats:
    """Return zeros for what is rounding noise throughout."""
    return np.zeros_like(values) if is_noise(float(np.abs(values).max()), scale) else values


def _curves(time: Floats, names: tuple[str, ...], values: tuple[Floats, ...]) -> Curves:
    thinned = MinMaxDecimation(names, ("value",))
    thinned.update(time, (np.stack(values),), float(time[-1] - time[0]))
    return thinned.curves()


def joint_figure(name: str, slides: bool, time: Floats, values: tuple[Floats, ...]) -> Figure:
    """Return position, speed and load of a joint against time, without what is zero throughout."""
    units = ("m", "m/s", "N") if slides else ("rad", "rad/s", "N m")
    what = ("position", "speed", "drive's force" if slides else "drive's torque")
    curves, panels = _curves(time, what, values), [k for k in range(len(what)) if values[k].any()]
    height = 130 * len(panels) + 20

    def draw(canvas: Canvas) -> None:
        for row, k in enumerate(panels, start=1):
            axes = panel(canvas, height - 130 * row + 12, 96, height)
            axes.plot(*curves.line("value", k), color=SERIES[k])
            axes.set_title(f"{what[k]} [{units[k]}]")
            axes.tick_params(labelbottom=row == len(panels))
            few_ticks(axes)
        axes.set_xlabel("time [s]", labelpad=1)

    ranges = [f"{what[k]} {number(values[k].min())} to {number(values[k].max())} {units[k]}" for k in panels]
    alt = f"Joint {printable(name)} against time: {', '.join(ranges)}"
    return Figure(printable(name), alt, plot(WIDE, height, draw, f"joint {name}"))


def energy_figures(result: Simulation) -> list[Figure]:
    """Return energies and work that are not zero throughout, and the drift where it is more than rounding."""
    figures, size, work = result.figures, simulation_sizes(result).energy, result.work - result.work[0]
    stored = figures.energy - figures.energy[0]
    given = {"kinetic": figures.kinetic, "potential": figures.energy - figures.kinetic, "work done": work}
    parts = {name: kept for name, values in given.items() if (kept := quiet(values, size)).any()}
    found = []
    if parts:
        what = "Energies, and work done by drives and wrenches"
        largest = f"Against time; the largest kinetic energy is {number(figures.kinetic.max(), size)} J"
        found.append(Figure(what, largest, _lines(result.time, parts, "parts", 0)))
    if result.energy_drift > NOISE * size:
        off = f"Stored energy less work done against time, at most {drift_text(result.energy_drift, size)} J from zero"
        drift = _lines(result.time, {"drift": stored - work}, "drift", 5)
        found.append(Figure("Drift: stored energy less work", off, drift))
    return found


def _lines(time: Floats, parts: dict[str, Floats], name: str, first: int) -> str:
    curves = _curves(time, tuple(parts), tuple(parts.values()))
    lines = {label: curves.line("value", k) for k, label in enumerate(parts)}
    return plot(WIDE, LOW, lambda canvas: against_time(canvas, lines, "J", left=0.2, width=0.76, first=first), name)


_POINTS = 1500
"""Points of a line."""
_TALL = 420


def torque_figure(found: Comparison, j: int) -> Figure:
    """Return measured and computed torque of a joint over time, and below what is left, before and after effects."""
    joint, curves = found.joints[j], found.curves
    every = slice(None, None, max(1, len(curves.time) // _POINTS))
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
    every = slice(None, None, max(1, len(curves.time) // _POINTS))
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
