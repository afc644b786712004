"""The largest of each kind that a case has, by unit, for what is small beside it is shown as 0. A moment is told also
beside the largest force at the robot's reach, whose rounding makes its own, a power beside torque times speed."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from robodyn.programs.vectors import length, product
from robodyn.report.table import moment, number
from robodyn.support.floats import Floats

if TYPE_CHECKING:
    from robodyn.equations.free_body.bodies import FreeBodies
    from robodyn.loads.result import Result
    from robodyn.robot.model import Model
    from robodyn.simulation.result import Simulation


class Sizes(dict[str, float]):
    """The largest of each unit, and numbers beside it as text."""

    def number(self, value: float, unit: str) -> str:
        return number(value, self[unit])

    def amount(self, value: float, unit: str) -> str:
        return f"{number(value, self[unit])} {unit}"

    def moment(self, when: float, value: float, unit: str) -> str:
        return moment(when, value, self[unit])


def sizes(forces: Iterable[float], moments: Iterable[float], reach: float) -> Sizes:
    """Return the sizes of all forces [N] and moments [N m] of a case, of either sign, on a robot of this reach [m]."""
    force = max(map(abs, forces), default=0.0)
    return Sizes({"N": force, "N m": max(max(map(abs, moments), default=0.0), force * reach)})


def speed_unit(unit: str) -> str:
    """Return the unit of a joint's speed by that of its load."""
    return "m/s" if unit == "N" else "rad/s"


def result_sizes(result: Result) -> Sizes:
    """Return those of loads, speeds, powers and energies along a motion."""
    joints, checks = result.joints, result.checks
    peaks = {unit: [joint.peak for joint in joints if joint.unit == unit] for unit in ("N", "N m")}
    base = {kind: [part.peak for part in result.base_wrench if part.name[0] == kind] for kind in "fm"}
    found = sizes(
        [*peaks["N"], *base["f"], checks.largest_force], [*peaks["N m"], *base["m"], checks.largest_moment], 0.0
    )
    for unit in ("N", "N m"):
        found[speed_unit(unit)] = max((abs(joint.max_speed) for joint in joints if joint.unit == unit), default=0.0)
    balance = checks.energy_balance
    found["W"] = max(found["N"] * found["m/s"], found["N m"] * found["rad/s"])
    found["J"] = max(found["W"] * result.duration, balance.turnover, balance.stored_most)
    return found


def free_body_sizes(found: FreeBodies) -> Sizes:
    """Return those of the forces and moments on every body of a robot."""
    actions = [action for body in found.bodies for action in body.actions]
    places = [place for body in found.bodies for place in (body.pose.p, body.pose.p + product(body.pose.R, body.com))]
    return sizes(
        (float(np.abs(action.force).max()) for action in actions),
        (float(np.abs(each).max()) for action in actions for each in (action.moment, action.at_origin)),
        max((length(place - places[0]) for place in places), default=0.0),
    )


def simulation_sizes(result: Simulation) -> Sizes:
    """Return those along a simulated motion: an angle beside 1 rad, a length beside the reach, an acceleration also
    beside the squared speed and gravity, a load beside the robot's weight."""
    model, figures, reach = result.model, result.figures, result.model.reach
    gravity = length(np.array(result.scene.gravity))
    positions, speeds = (np.array(units) for units in motion_units(model))
    slides, turns = speeds == "m/s", speeds == "rad/s"
    size = Sizes({"rad": 1.0, "": 1.0, "m": max(reach, _largest(result.q[:, positions == "m"]))})
    size["rad/s"] = _largest(result.qd[:, turns])
    size["m/s"] = max(_largest(result.qd[:, slides]), size["rad/s"] * reach)
    size["rad/s^2"] = max(_largest(figures.qdd[:, turns]), size["rad/s"] ** 2)
    size["m/s^2"] = max(_largest(figures.qdd[:, slides]), size["rad/s^2"] * reach, gravity)
    forces = [figures.tau[:, slides], *([result.loops.wrenches[..., :3]] if result.loops else [])]
    size["N"] = max(*map(_largest, forces), model.total_mass * gravity)
    size["N m"] = max(_largest(figures.tau[:, turns]), size["N"] * reach)
    size["J"] = max(map(_largest, (figures.energy, figures.kinetic, result.work)))
    size["N s"] = _largest(figures.linear)
    size["N m s"] = max(_largest(figures.angular), size["N s"] * reach)
    return size


def motion_units(model: Model) -> tuple[list[str], list[str]]:
    """Return the units of coordinates, "" for those of quaternions, and of rates."""
    positions, speeds = [], []
    for joint in model.independent:
        slides = joint.kind == "prismatic"
        positions += ["m"] * 3 + [""] * 4 if joint.kind == "floating" else ["m" if slides else "rad"]
        speeds += ["rad/s"] * 3 + ["m/s"] * 3 if joint.kind == "floating" else ["m/s" if slides else "rad/s"]
    return positions, speeds


def _largest(values: Floats) -> float:
    return float(np.abs(values).max(initial=0.0))
