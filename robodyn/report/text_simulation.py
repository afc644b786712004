"""The result of `simulate` as text for a person."""

from __future__ import annotations

import numpy as np

from robodyn.report.table import PLAIN, Content, Page, number, printable
from robodyn.report.text_loops import loops_text
from robodyn.simulation.result import Simulation

FREE = "ODE, qdd = M^-1 (tau - bias) by articulated bodies"
LOOPED = "index-1 DAE, M qdd + bias = tau + J^T lambda, J qdd = -J' qd by M = C C^T and C^-1 J^T = Q R"


def simulation_text(result: Simulation, explain: bool = False, page: Page = PLAIN) -> str:
    """The report: what was integrated and how, where the motion ends, what it reaches, and what drifted.

    Args:
        explain: add why each effect is on or off.
    """
    parts = [_head(result), page.table(_coordinates(result)), page.table(_rates(result)), _drift(result)]
    if result.loops:
        parts.append(loops_text(result.loops, page))
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


def _coordinates(result: Simulation) -> Content:
    rows = [
        (name, *(number(x) for x in (q[0], q[-1], q.min(), q.max())))
        for name, q in zip(result.model.coordinates, result.q.T, strict=True)
    ]
    return ("position", "at the start", "at the end", "least", "largest"), rows


def _rates(result: Simulation) -> Content:
    driven = set(result.driven)
    rows = [
        (
            name,
            *(number(x) for x in (qd[0], qd[-1], np.abs(qd).max(), np.abs(qdd).max())),
            number(tau[np.abs(tau).argmax()]) if k in driven else "-",
        )
        for k, (name, qd, qdd, tau) in enumerate(
            zip(result.model.rates, result.qd.T, result.qdd.T, result.tau.T, strict=True)
        )
    ]
    return ("speed", "at the start", "at the end", "largest", "acceleration", "drive's peak"), rows


def _drift(result: Simulation) -> str:
    energy, kinetic = result.figures.energy, float(result.figures.kinetic.max())
    relative = result.energy_drift / kinetic if kinetic else 0.0
    lines = [
        f"energy: {number(energy[0])} J at the start, {number(energy[-1])} J at the end, work "
        f"{number(result.work[-1], kinetic)} J; drift {result.energy_drift:.1e} J, "
        f"{relative:.0e} of the largest kinetic energy\n"
    ]
    if result.free:
        linear, angular = result.momentum_drift
        lines.append(
            f"momentum: drift {linear:.1e} N s linear, less the weight's, and {angular:.1e} N m s angular, "
            "about the centre of mass\n"
        )
    return "".join(lines)
