"""The result of `simulate` as text for a person."""

from __future__ import annotations

import numpy as np

from robodyn.report.limits_words import limits_text, simulation_limits, use
from robodyn.report.sizes import MotionSizes, linear, simulation_sizes, speed_unit
from robodyn.report.table import PLAIN, Content, Page, drift_text, moment, number, printable, relative_text
from robodyn.report.text_loops import loops_text
from robodyn.simulation.result import Simulation

FREE = "ODE, qdd = M^-1 (tau - bias) by articulated bodies"
LOOPED = "index-1 DAE, M qdd + bias = tau + J^T lambda, J qdd = -J' qd by M = C C^T and C^-1 J^T = Q R"


def simulation_text(result: Simulation, explain: bool = False, page: Page = PLAIN) -> str:
    """The report: what was integrated and how, where the motion ends, what it reaches, and what drifted.

    Args:
        explain: add why each effect is on or off.
    """
    size = simulation_sizes(result)
    tables = _coordinates(result, size), _rates(result, size), *([_limits(result, size)] if result.joints else [])
    parts = [_head(result), *map(page.table, tables), _drift(result, size)]
    if result.loops:
        parts.append(loops_text(result.loops, page, result.model.reach))
    if explain:
        rows = [(effect.name, "on" if why.active else "off", why.reason) for effect, why in result.effects]
        parts.append(f"Effects\n{page.table((('effect', '', 'why'), rows))}")
    if result.ended:
        how = 'joint_limits = "spring" or "ignore" in a scene goes on'
        parts.append(f"ENDED EARLY: {printable(result.ended)} ({how})\n")
    if result.joints:
        headline = simulation_limits(result).headline
        parts.append(limits_text(len(result.joints), result.exceeded, result.limits, headline, page))
    parts.append("".join(f"warning: {printable(doubt.said)}\n" for doubt in result.doubts))
    parts.append("".join(f"note: {printable(line)}\n" for line in result.notes))
    return "\n".join(part for part in parts if part)


def _head(result: Simulation) -> str:
    x, y, z = result.scene.gravity
    on = [effect.name for effect, why in result.effects if why.active]
    length = f"steps of {result.step:.6g} s" if result.step is not None else f"steps, rtol {result.rtol:.3g}"
    return (
        f"{printable(result.model.name)}: {result.time[-1]:.6g} s, gravity ({x:g}, {y:g}, {z:g}) m/s^2\n"
        f"effects on: {', '.join(on)}; no contact\n"
        f"form: {LOOPED if result.loops else FREE}\n"
        f"method: {result.method.name} of order {result.method.order} ({result.method.about}), "
        f"{result.steps} {length}, {result.evaluations} evaluations, {result.executor}\n"
    )


def _coordinates(result: Simulation, size: MotionSizes) -> Content:
    lengths, _ = linear(result.model)
    floating = (joint.name for joint in result.model.independent if joint.kind == "floating")
    turns = {f"{name}_{part}" for name in floating for part in ("qx", "qy", "qz", "qw")}
    rows = []
    for k, (name, q) in enumerate(zip(result.model.coordinates, result.q.T, strict=True)):
        unit = "m" if lengths[k] else "" if name in turns else "rad"
        rows.append((name, unit, *(number(x, size.q[k]) for x in (q[0], q[-1], q.min(), q.max()))))
    return ("position", "unit", "at the start", "at the end", "least", "largest"), rows


def _rates(result: Simulation, size: MotionSizes) -> Content:
    _, sliding = linear(result.model)
    rows = []
    for k, (name, qd, qdd) in enumerate(zip(result.model.rates, result.qd.T, result.qdd.T, strict=True)):
        unit = "m/s" if sliding[k] else "rad/s"
        speeds = (number(x, size.qd[k]) for x in (qd[0], qd[-1], np.abs(qd).max()))
        rows.append((name, unit, *speeds, f"{number(np.abs(qdd).max(), size.qdd[k])} {unit}^2"))
    return ("speed", "unit", "at the start", "at the end", "largest", "largest acceleration"), rows


def _limits(result: Simulation, size: MotionSizes) -> Content:
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
    return ("joint", "max speed", "at [s]", "of velocity limit", "drive's peak", "at [s]", "of effort limit"), rows


def _drift(result: Simulation, size: MotionSizes) -> str:
    energy, kinetic = result.figures.energy, float(result.figures.kinetic.max())
    relative = result.energy_drift / kinetic if kinetic else 0.0
    start, end, work = (number(x, size.energy) for x in (energy[0], energy[-1], result.work[-1]))
    lines = [
        f"energy: {start} J at the start, {end} J at the end, work {work} J; "
        f"drift {drift_text(result.energy_drift, size.energy)} J, {relative_text(relative)} of "
        "the largest kinetic energy\n"
    ]
    if result.free:
        linear, angular = result.momentum_drift
        most = float(np.abs(result.figures.linear).max())
        turning = max(float(np.abs(result.figures.angular).max()), most * result.model.reach)
        lines.append(
            f"momentum: drift {drift_text(linear, most)} N s linear, less the weight's, and "
            f"{drift_text(angular, turning)} N m s angular, about the centre of mass\n"
        )
    return "".join(lines)
