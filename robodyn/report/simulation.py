"""The result of `simulate`: what was integrated and how, what the motion reaches, and what drifted."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robodyn.report.document import Paragraph, Section, Table, paragraphs, remarks
from robodyn.report.limits import limits_section, use
from robodyn.report.sizes import MotionSizes, linear, simulation_sizes, sizes, speed_unit
from robodyn.report.table import drift_text, gravity_text, moment, number, relative_text
from robodyn.simulation.loop_figures import LoopFigures
from robodyn.simulation.result import Simulation
from robodyn.support.wording import count

FREE = "ODE, qdd = M^-1 (tau - bias) by articulated bodies"
LOOPED = "index-1 DAE, M qdd + bias = tau + J^T lambda, J qdd = -J' qd by M = C C^T and C^-1 J^T = Q R"


_NAMED = 8
"""Equations of loops that are named; of more, the number."""


def simulation_sections(result: Simulation, explain: bool = False) -> Iterator[Section]:
    """Yield what was integrated and how, where the motion ends, what it reaches, and what drifted.

    Args:
        explain: add why each effect is on or off.
    """
    size = simulation_sizes(result)
    yield paragraphs(_head(result))
    yield [_coordinates(result, size)]
    yield [_rates(result, size)]
    if result.joints:
        yield [_limits(result, size)]
    yield paragraphs(_drift(result, size))
    if result.loops:
        yield paragraphs(_counted(result.loops))
        yield [_loops(result.loops, result.model.reach)]
    if explain:
        rows = [(effect.name, "on" if why.active else "off", why.reason) for effect, why in result.effects]
        yield [Table("Effects", ("effect", "", "why"), rows)]
    if result.ended:
        how = 'joint_limits = "spring" or "ignore" in a scene goes on'
        yield [Paragraph(f"ENDED EARLY: {result.ended} ({how})")]
    if result.joints:
        yield limits_section(result)
    yield remarks("warning", (caveat.text for caveat in result.caveats))
    yield remarks("note", result.notes)


def _head(result: Simulation) -> tuple[str, ...]:
    on = [effect.name for effect, why in result.effects if why.active]
    length = f"steps of {result.step:.6g} s" if result.step is not None else f"steps, rtol {result.rtol:.3g}"
    return (
        f"{result.model.name}: {result.time[-1]:.6g} s, {gravity_text(result.scene.gravity)}",
        f"effects on: {', '.join(on)}; no contact",
        f"form: {LOOPED if result.loops else FREE}",
        f"method: {result.method.name} of order {result.method.order} ({result.method.about}), "
        f"{result.steps} {length}, {result.evaluations} evaluations, {result.executor}",
    )


def _coordinates(result: Simulation, size: MotionSizes) -> Table:
    lengths, _ = linear(result.model)
    floating = (joint.name for joint in result.model.independent if joint.kind == "floating")
    turns = {f"{name}_{part}" for name in floating for part in ("qx", "qy", "qz", "qw")}
    rows = []
    for k, (name, q) in enumerate(zip(result.model.coordinates, result.q.T, strict=True)):
        unit = "m" if lengths[k] else "" if name in turns else "rad"
        rows.append((name, unit, *(number(x, size.q[k]) for x in (q[0], q[-1], q.min(), q.max()))))
    return Table("", ("position", "unit", "at the start", "at the end", "least", "largest"), rows)


def _rates(result: Simulation, size: MotionSizes) -> Table:
    _, sliding = linear(result.model)
    rows = []
    for k, (name, qd, qdd) in enumerate(zip(result.model.rates, result.qd.T, result.qdd.T, strict=True)):
        unit = "m/s" if sliding[k] else "rad/s"
        speeds = (number(x, size.qd[k]) for x in (qd[0], qd[-1], np.abs(qd).max()))
        rows.append((name, unit, *speeds, f"{number(np.abs(qdd).max(), size.qdd[k])} {unit}^2"))
    return Table("", ("speed", "unit", "at the start", "at the end", "largest", "largest acceleration"), rows)


def _limits(result: Simulation, size: MotionSizes) -> Table:
    rows = []
    for k, joint in zip(result.driven, result.joints, strict=True):
        load, speed = size.tau[k], size.qd[k]
        peak = (f"{number(joint.peak, load)} {joint.unit}", moment(joint.peak_time, joint.peak, load))
        rows.append(
            (
                joint.name,
                f"{number(joint.max_speed, speed)} {speed_unit(joint.unit)}",
                moment(joint.max_speed_time, joint.max_speed, speed),
                use(joint.max_speed, joint.velocity_limit),
                *(peak if joint.driven else ("-", "-")),
                use(joint.peak, joint.effort_limit),
            )
        )
    head = ("joint", "max speed", "at [s]", "of velocity limit", "drive's peak", "at [s]", "of effort limit")
    return Table("", head, rows)


def _drift(result: Simulation, size: MotionSizes) -> Iterator[str]:
    energy, kinetic = result.figures.energy, float(result.figures.kinetic.max())
    relative = result.energy_drift / kinetic if kinetic else 0.0
    start, end, work = (number(x, size.energy) for x in (energy[0], energy[-1], result.work[-1]))
    yield (
        f"energy: {start} J at the start, {end} J at the end, work {work} J; "
        f"drift {drift_text(result.energy_drift, size.energy)} J, {relative_text(relative)} of "
        "the largest kinetic energy"
    )
    if result.free:
        linear, angular = result.momentum_drift
        most = float(np.abs(result.figures.linear).max())
        turning = max(float(np.abs(result.figures.angular).max()), most * result.model.reach)
        yield (
            f"momentum: drift {drift_text(linear, most)} N s linear, less the weight's, and "
            f"{drift_text(angular, turning)} N m s angular, about the centre of mass"
        )


def _loops(loops: LoopFigures, reach: float) -> Table:
    """Return what each loop carries at most, and how far it comes apart.

    Args:
        reach: of the robot [m].
    """
    force, turning = (np.sqrt(np.square(loops.wrenches[:, :, part]).sum(axis=2)) for part in (slice(3), slice(3, 6)))
    size = sizes(force.ravel().tolist(), turning.ravel().tolist(), reach)
    apart = max(reach, 1.0)
    rows = [
        (
            name,
            number(f, size["N"]),
            number(m, size["N m"]),
            drift_text(gap, apart),
            drift_text(slip, apart),
        )
        for name, f, m, gap, slip in zip(
            loops.names, force.max(axis=0), turning.max(axis=0), loops.gap, loops.slip, strict=True
        )
    ]
    head = ("loop", "largest force [N]", "largest moment [N m]", "|phi| [m, rad]", "|phi'| [m/s, rad/s]")
    return Table("", head, rows)


def _counted(loops: LoopFigures) -> list[str]:
    """Return how many equations there are, and which of them are left out."""
    kept = loops.equations - len(loops.dropped)
    lines = [f"loops: {count(loops.equations, 'equation')}, {loops.rank} of them independent at the start"]
    lines[0] += f"; degrees of freedom left: {loops.freedoms}; {loops.stabilised}"
    if loops.dropped:
        names = ", ".join(loops.dropped[:_NAMED])
        more = len(loops.dropped) - _NAMED
        lines.append(f"left out, for the others imply them: {names}{f' and {more} more' if more > 0 else ''}")
    if loops.rank < kept:
        lines.append(f"{kept - loops.rank} depend on the others there: how they share their reactions is arbitrary")
    return lines
