"""The result of `simulate` as a report for people."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from robodyn.history import Curves, Floats, Thinned
from robodyn.report.document import (
    Block,
    Document,
    Download,
    Figure,
    Gallery,
    Heading,
    Paragraph,
    Verdict,
    csv_text,
    downloads,
)
from robodyn.report.json_simulation import simulation_json
from robodyn.report.sizes import simulation_sizes
from robodyn.report.table import drift_text, number, printable, relative_text
from robodyn.report.text_blocks import blocks_of
from robodyn.report.text_simulation import simulation_text
from robodyn.simulation.result import Simulation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

PLOTTED = 12
"""Joints that have plots; those that move most where there are more."""
_HOW = "robodyn simulate --format json and --out write it to a file"
_DRIFT = 1e-3
"""Relative to the largest kinetic energy; above it steps are too long."""


def simulation_page(result: Simulation, pictures: bool = True) -> Document:
    """How the motion ends and how far it can be trusted, then the motion itself."""
    what = f"Simulated motion: {result.model.n} degrees of freedom, {result.time[-1]:.6g} s, {result.steps} steps"
    blocks: list[Block] = [_verdict(result)]
    if pictures:
        blocks += [*_poses(result), *_plots(result)]
    blocks += [Heading("In numbers"), *blocks_of(lambda page: simulation_text(result, True, page), "Motion")]
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
    from robodyn.report.robot_picture import robot_figure, shapes_of

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
    shown = sorted(sorted(joints, key=lambda joint: -travel[joint.name])[:PLOTTED], key=joints.index)
    figures = []
    for joint in shown:
        values = (result.q[:, joint.coordinate], result.qd[:, joint.rate], result.tau[:, joint.rate])
        figures.append(_joint(joint.name, joint.kind == "prismatic", result.time, values))
    blocks: list[Block] = [Heading("Along the motion")]
    if len(shown) < len(joints):
        blocks.append(Paragraph(f"The {len(shown)} joints that move most; the tables have all {len(joints)}."))
    if figures:
        blocks.append(Gallery(tuple(figures)))
    return [*blocks, Heading("Energy"), Gallery(tuple(_energies(result)))]


def _curves(time: Floats, names: tuple[str, ...], values: tuple[Floats, ...]) -> Curves:
    thinned = Thinned(names, ("value",))
    thinned.update(time, (np.stack(values),), float(time[-1] - time[0]))
    return thinned.curves()


def _joint(name: str, slides: bool, time: Floats, values: tuple[Floats, ...]) -> Figure:
    from robodyn.report.figures import SERIES, few_ticks, plot

    units = ("m", "m/s", "N") if slides else ("rad", "rad/s", "N m")
    what = ("position", "speed", "drive's force" if slides else "drive's torque")
    curves = _curves(time, what, values)

    def draw(canvas: Canvas) -> None:
        for k, bottom in enumerate((292, 162, 32)):
            axes = canvas.add_axes((0.16, bottom / 410, 0.8, 96 / 410))
            axes.plot(*curves.line("value", k), color=SERIES[k])
            axes.set_title(f"{what[k]} [{units[k]}]")
            axes.tick_params(labelbottom=k == 2)
            few_ticks(axes)
        axes.set_xlabel("time [s]", labelpad=1)

    ranges = (
        f"{each} {number(v.min())} to {number(v.max())} {u}" for each, v, u in zip(what, values, units, strict=True)
    )
    alt = f"Joint {printable(name)} against time: {', '.join(ranges)}"
    return Figure(printable(name), alt, plot(380, 410, draw, f"joint {name}"))


def _energies(result: Simulation) -> list[Figure]:
    from robodyn.report.figures import SERIES, few_ticks, plot

    figures, work = result.figures, result.work - result.work[0]
    stored = figures.energy - figures.energy[0]
    names = ("kinetic", "potential", "work done")
    parts = _curves(result.time, names, (figures.kinetic, figures.energy - figures.kinetic, work))
    drift = _curves(result.time, ("drift",), (stored - work,))

    def style(axes: Axes) -> None:
        axes.set_title("[J]")
        axes.set_xlabel("time [s]")
        few_ticks(axes, up=6)

    def draw_parts(canvas: Canvas) -> None:
        axes = canvas.add_axes((0.16, 0.15, 0.8, 0.68))
        for k, name in enumerate(names):
            axes.plot(*parts.line("value", k), color=SERIES[k], label=name)
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.02), ncols=3, columnspacing=1.0)
        style(axes)

    def draw_drift(canvas: Canvas) -> None:
        axes = canvas.add_axes((0.2, 0.15, 0.76, 0.68))
        axes.plot(*drift.line("value", 0), color=SERIES[5])
        style(axes)

    largest = f"the largest kinetic energy is {number(figures.kinetic.max())} J"
    size = simulation_sizes(result).energy
    off = f"Stored energy less work done against time, at most {drift_text(result.energy_drift, size)} J from zero"
    return [
        Figure(
            "Energies, and work done by drives and wrenches",
            f"Against time; {largest}",
            plot(380, 280, draw_parts, "parts"),
        ),
        Figure("Drift: stored energy less work", off, plot(380, 280, draw_drift, "drift")),
    ]
