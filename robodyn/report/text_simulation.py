"""The result of `simulate` as text for a person."""

from __future__ import annotations

import numpy as np

from robodyn.report.sizes import MotionSizes, simulation_sizes
from robodyn.report.table import PLAIN, Content, Page, drift_text, number, printable, relative_text
from robodyn.report.text_loops import loops_text
from robodyn.simulation.result import Simulation
from robodyn.ties import first_largest

FREE = "ODE, qdd = M^-1 (tau - bias) by articulated bodies"
LOOPED = "index-1 DAE, M qdd + bias = tau + J^T lambda, J qdd = -J' qd by M = C C^T and C^-1 J^T = Q R"


def simulation_text(result: Simulation, explain: bool = False, page: Page = PLAIN) -> str:
    """The report: what was integrated and how, where the motion ends, what it reaches, and what drifted.

    Args:
        explain: add why each effect is on or off.
    """
    size = simulation_sizes(result)
    tables = page.table(_coordinates(result, size)), page.table(_rates(result, size))
    parts = [_head(result), *tables, _drift(result, size)]
    if result.loops:
        parts.append(loops_text(result.loops, page, result.model.reach))
    if explain:
        rows = [(effect.name, "on" if why.active else "off", why.reason) for effect, why in result.effects]
        parts.append(f"Effects\n{page.table((('effect', '', 'why'), rows))}")
    if result.ended:
        parts.append(f"ENDED EARLY: {printable(result.ended)}\n")
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
    rows = [
        (name, *(number(x, scale) for x in (q[0], q[-1], q.min(), q.max())))
        for name, q, scale in zip(result.model.coordinates, result.q.T, size.q, strict=True)
    ]
    return ("position", "at the start", "at the end", "least", "largest"), rows


def _rates(result: Simulation, size: MotionSizes) -> Content:
    driven = set(result.driven)
    rows = [
        (
            name,
            *(number(x, size.qd[k]) for x in (qd[0], qd[-1], np.abs(qd).max())),
            number(np.abs(qdd).max(), size.qdd[k]),
            number(tau[first_largest(np.abs(tau))], size.tau[k]) if k in driven else "-",
        )
        for k, (name, qd, qdd, tau) in enumerate(
            zip(result.model.rates, result.qd.T, result.qdd.T, result.tau.T, strict=True)
        )
    ]
    return ("speed", "at the start", "at the end", "largest", "acceleration", "drive's peak"), rows


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
