"""The course of a simulated motion as plots: joints, and energies."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from robodyn.loads.history import Curves, Thinned
from robodyn.report.document import Figure
from robodyn.report.pictures.figures import SERIES, few_ticks, plot
from robodyn.report.pictures.panels import LOW, WIDE, against_time, panel
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
    thinned = Thinned(names, ("value",))
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
