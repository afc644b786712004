"""The result of `simulate` as a report for people."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from robodyn.loads.history import Curves, Thinned
from robodyn.report.document import (
    Block,
    Document,
    Download,
    Figure,
    Gallery,
    Heading,
    Level,
    Paragraph,
    Verdict,
    csv_text,
    downloads,
    on_page,
)
from robodyn.report.json.runs import simulation_json
from robodyn.report.limits import simulation_limits
from robodyn.report.simulation import simulation_sections
from robodyn.report.sizes import simulation_sizes
from robodyn.report.table import drift_text, is_noise, number, printable, relative_text
from robodyn.simulation.result import Simulation
from robodyn.support.floats import Floats, ranked

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

PLOTTED = 12
"""Joints that have plots; those that move most where there are more."""
_HOW = "robodyn simulate --format json and --out write it to a file"
_WORST_FIRST: tuple[Level, ...] = ("bad", "doubtful", "neutral", "good")
_DRIFT = 1e-3
"""Relative to the largest kinetic energy; above it steps are too long."""


def simulation_page(result: Simulation, pictures: bool = True) -> Document:
    """How the motion ends and how far it can be trusted, then the motion itself."""
    what = f"Simulated motion: {result.model.n} degrees of freedom, {result.time[-1]:.6g} s, {result.steps} steps"
    verdicts = [_verdict(result), *([simulation_limits(result)] if result.joints or result.doubts else [])]
    blocks: list[Block] = [*sorted(verdicts, key=lambda verdict: _WORST_FIRST.index(verdict.level))]
    if pictures:
        blocks += [*_poses(result), *_plots(result)]
    blocks += [Heading("In numbers"), *on_page(simulation_sections(result, explain=True), "Motion")]
    table = csv_text(("time", *result.names), np.column_stack((result.time, result.columns)).tolist())
    files = [
        Download("result.json", "application/json", simulation_json(result)),
        Download("motion.csv", "text/csv", table),
    ]
    blocks += [Heading("Data"), downloads(files, _HOW)]
    return Document(result.model.name, what, tuple(blocks))


def _verdict(result: Simulation) -> Verdict:
    kinetic, size = float(result.figures.kinetic.max()), simulation_sizes(result).energy
    relative = result.energy_drift / kinetic if kinetic else 0.0
    energy = (
        f"The energy drifts by {drift_text(result.energy_drift, size)} J, {relative_text(relative)} of the largest "
        f"kinetic energy of {number(kinetic, size)} J."
    )
    if result.ended:
        return Verdict("bad", f"The motion ended early, at {result.time[-1]:.6g} s", (result.ended, energy))
    if relative > _DRIFT:
        return Verdict("doubtful", "The energy drifts: take shorter steps or a smaller tolerance", (energy,))
    return Verdict("good", f"The motion ran for its {result.time[-1]:.6g} s, and its energy balances", (energy,))


def _poses(result: Simulation) -> list[Block]:
    from robodyn.report.pictures.robot import robot_figure, shapes_of

    shapes, why = shapes_of(result.model)
    figures = [
        robot_figure(result.model, result.q[row], "", f"{name}, {result.time[row]:.6g} s", shapes, f"picture {row}")
        for row, name in ((0, "the start"), (-1, "the end"))
    ]
    return [Heading("Start and end"), Gallery(tuple(figures)), *([Paragraph(why)] if why else [])]


def _plots(result: Simulation) -> list[Block]:
    model = result.model
    joints = [joint for joint in model.independent if joint.kind != "floating"]
    travel = {joint.name: float(np.ptp(result.q[:, joint.coordinate])) for joint in joints}
    shown = sorted(ranked(joints, key=lambda joint: travel[joint.name])[:PLOTTED], key=joints.index)
    size, figures = simulation_sizes(result), []
    for joint in shown:
        at, rate = joint.coordinate, joint.rate
        given = (
            (result.q[:, at], size.q[at]),
            (result.qd[:, rate], size.qd[rate]),
            (result.tau[:, rate], size.tau[rate]),
        )
        values = tuple(_quiet(*each) for each in given)
        if any(each.any() for each in values):
            figures.append(_joint(joint.name, joint.kind == "prismatic", result.time, values))
    blocks: list[Block] = [Heading("Along the motion")] if figures else []
    if len(figures) < len(joints):
        count = f"{len(figures)} of {len(joints)} joints"
        blocks.append(Paragraph(f"The joints that move most, {count}, without plots of zeros; the tables have all."))
    if figures:
        blocks.append(Gallery(tuple(figures)))
    if energies := _energies(result):
        blocks += [Heading("Energy"), Gallery(tuple(energies))]
    return blocks


def _quiet(values: Floats, scale: float) -> Floats:
    """Zeros for what is rounding noise throughout."""
    return np.zeros_like(values) if is_noise(float(np.abs(values).max()), scale) else values


def _curves(time: Floats, names: tuple[str, ...], values: tuple[Floats, ...]) -> Curves:
    thinned = Thinned(names, ("value",))
    thinned.update(time, (np.stack(values),), float(time[-1] - time[0]))
    return thinned.curves()


def _joint(name: str, slides: bool, time: Floats, values: tuple[Floats, ...]) -> Figure:
    from robodyn.report.pictures.figures import SERIES, few_ticks, plot

    units = ("m", "m/s", "N") if slides else ("rad", "rad/s", "N m")
    what = ("position", "speed", "drive's force" if slides else "drive's torque")
    curves, panels = _curves(time, what, values), [k for k in range(len(what)) if values[k].any()]
    height = 130 * len(panels) + 20

    def draw(canvas: Canvas) -> None:
        for row, k in enumerate(panels, start=1):
            bottom = height - 130 * row + 12
            axes = canvas.add_axes((0.16, bottom / height, 0.8, 96 / height))
            axes.plot(*curves.line("value", k), color=SERIES[k])
            axes.set_title(f"{what[k]} [{units[k]}]")
            axes.tick_params(labelbottom=row == len(panels))
            few_ticks(axes)
        axes.set_xlabel("time [s]", labelpad=1)

    ranges = [f"{what[k]} {number(values[k].min())} to {number(values[k].max())} {units[k]}" for k in panels]
    alt = f"Joint {printable(name)} against time: {', '.join(ranges)}"
    return Figure(printable(name), alt, plot(380, height, draw, f"joint {name}"))


def _energies(result: Simulation) -> list[Figure]:
    """Energies and work that are not zero throughout, and the drift where it is more than rounding."""
    figures, size, work = result.figures, simulation_sizes(result).energy, result.work - result.work[0]
    stored = figures.energy - figures.energy[0]
    given = {"kinetic": figures.kinetic, "potential": figures.energy - figures.kinetic, "work done": work}
    parts = {name: quiet for name, values in given.items() if (quiet := _quiet(values, size)).any()}
    found = []
    if parts:
        what = "Energies, and work done by drives and wrenches"
        largest = f"Against time; the largest kinetic energy is {number(figures.kinetic.max(), size)} J"
        found.append(Figure(what, largest, _lines(result.time, parts, "parts", 0)))
    if not is_noise(result.energy_drift, size):
        off = f"Stored energy less work done against time, at most {drift_text(result.energy_drift, size)} J from zero"
        drift = _lines(result.time, {"drift": stored - work}, "drift", 5)
        found.append(Figure("Drift: stored energy less work", off, drift))
    return found


def _lines(time: Floats, parts: dict[str, Floats], name: str, colour: int) -> str:
    """Energies against time, named where there are several."""
    from robodyn.report.pictures.figures import SERIES, few_ticks, plot

    curves = _curves(time, tuple(parts), tuple(parts.values()))

    def draw(canvas: Canvas) -> None:
        axes = canvas.add_axes((0.2, 0.15, 0.76, 0.68))
        for k, label in enumerate(parts):
            axes.plot(*curves.line("value", k), color=SERIES[colour + k], label=label)
        if len(parts) > 1:
            axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.02), ncols=3, columnspacing=1.0)
        axes.set_title("[J]")
        axes.set_xlabel("time [s]")
        few_ticks(axes, up=6)

    return plot(380, 280, draw, name)
