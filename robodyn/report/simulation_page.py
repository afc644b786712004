"""The result of `simulate` as a report for people."""

from __future__ import annotations

import numpy as np

from robodyn.report.document import (
    Block,
    Document,
    Gallery,
    Heading,
    Level,
    Paragraph,
    Verdict,
    csv_text,
    data_blocks,
    on_page,
)
from robodyn.report.json.runs import simulation_json
from robodyn.report.limits import limits_verdict
from robodyn.report.simulation import simulation_sections
from robodyn.report.sizes import simulation_sizes
from robodyn.report.table import drift_text, number, relative_text
from robodyn.simulation.result import Simulation
from robodyn.support.floats import ranked

PLOTTED = 12
"""Joints that have plots; those that move most where there are more."""
_WORST_FIRST: tuple[Level, ...] = ("bad", "doubtful", "neutral", "good")
_DRIFT = 1e-3
"""Relative to the largest kinetic energy; above it steps are too long."""


def simulation_page(result: Simulation, pictures: bool = True) -> Document:
    """Return how the motion ends and how far it can be trusted, then the motion itself."""
    what = f"Simulated motion: {result.model.n} degrees of freedom, {result.time[-1]:.6g} s, {result.steps} steps"
    verdicts = [_verdict(result), *([limits_verdict(result)] if result.joints or result.caveats else [])]
    blocks: list[Block] = [*sorted(verdicts, key=lambda verdict: _WORST_FIRST.index(verdict.level))]
    if pictures:
        blocks += [*_poses(result), *_plots(result)]
    blocks += [Heading("In numbers"), *on_page(simulation_sections(result, explain=True), "Motion")]
    table = csv_text(("time", *result.names), np.column_stack((result.time, result.columns)).tolist())
    files = [("result.json", simulation_json(result)), ("motion.csv", table)]
    blocks += data_blocks(files, "robodyn simulate --format json and --out write it to a file")
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
    from robodyn.report.pictures.simulation import energy_figures, joint_figure, quiet

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
        values = tuple(quiet(*each) for each in given)
        if any(each.any() for each in values):
            figures.append(joint_figure(joint.name, joint.kind == "prismatic", result.time, values))
    blocks: list[Block] = [Heading("Along the motion")] if figures else []
    if len(figures) < len(joints):
        count = f"{len(figures)} of {len(joints)} joints"
        blocks.append(Paragraph(f"The joints that move most, {count}, without plots of zeros; the tables have all."))
    if figures:
        blocks.append(Gallery(tuple(figures)))
    if energies := energy_figures(result):
        blocks += [Heading("Energy"), Gallery(tuple(energies))]
    return blocks
