"""Closed chains: where they close, and what the tree's equations with loops make of the same state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.loops.closed_start import closed_start
from robodyn.dynamics.loops.closure import GROUND_FRAME, Closure
from robodyn.dynamics.loops.find import closed_chain
from robodyn.dynamics.plan import applied, plan
from robodyn.equations.dae.coordinates import consistent
from robodyn.equations.dae.posed import Posed, posed
from robodyn.equations.dae.reactions import loop_wrenches
from robodyn.equations.dae.solve import Solution
from robodyn.equations.jobs import bias_plan
from robodyn.programs.vectors import cross
from robodyn.robot.configuration import Values, configuration, rates
from robodyn.robot.model import Frame, Model
from robodyn.robot.motion_types import Wrench
from robodyn.scene.scene import Entry, Scene

Floats = NDArray[np.float64]


def closed_state(model: Model, scene: Scene, at: Values | None, qd: Values) -> tuple[Floats, Floats]:
    """q and qd that close the loops: what is given stays, if the other coordinates alone can close them.

    What is not given begins at the scene's initial values.

    Args:
        at, qd: by order or by name; None for the scene's initial positions.

    Raises:
        InputError: the loops do not close near there.

    Accuracy: all constraints of the single bodies within 1e-14 of the robot's extent.
    """
    q, asked_q = _begun(model.coordinates, configuration(model, () if at is None else at), at, scene.initial_q)
    speeds, asked_qd = _begun(model.rates, rates(model, qd), qd, scene.initial_qd)
    asked = plan(model, replace(scene, initial_q=asked_q, initial_qd=asked_qd))
    q, speeds = np.split(closed_start(asked, np.concatenate((q, speeds))), [model.nq])
    return consistent(posed(model, scene, q.tolist(), speeds.tolist(), [0.0] * model.n))


def _begun(
    names: tuple[str, ...], values: Floats, given: Values | None, start: Mapping[str, Entry]
) -> tuple[Floats, dict[str, Entry]]:
    """Where the search begins, and what is to stay: what is given, or else the scene's initial values."""
    initial: dict[str, Entry] = {name: value for name, value in start.items() if not isinstance(value, str)}
    asked = initial
    if given is not None and len(given):
        among = given if isinstance(given, Mapping) else names
        asked = {name: float(value) for name, value in zip(names, values, strict=True) if name in among}
    begun = {**initial, **asked}
    return np.array([begun.get(name, value) for name, value in zip(names, values, strict=True)], dtype=float), asked


def by_the_tree(robot: Posed, rank: int, solution: Solution) -> tuple[Floats, list[tuple[int, Wrench]]]:
    """qdd of `robodyn.dynamics.loops`, and (i, wrench) pairs: what its loops do to both their bodies, about their
    origins.

    Where equations that it keeps depend on each other, nobody can say what each loop carries; then it is what
    `solution` says.

    Args:
        rank: of the loops' equations.
    """
    chain = closed_chain(plan(robot.model, robot.scene)).chain
    sample = replace(robot.sample, model=chain.model)
    terms = applied(bias_plan(robot.model, robot.scene).effects, sample, robot.scene)
    qdd, multipliers = chain.accelerations(sample, terms, list(robot.tau))
    if chain.count > rank:
        return np.array(qdd, dtype=float), loop_wrenches(robot.system, robot.at, solution.reactions.tolist())
    left, out = iter(multipliers), []
    for closure, place in zip(chain.closures, chain.equations(sample).places, strict=True):
        parts = [(equation, next(left)) for equation in closure.equations]
        force = np.sum([equation.force() * value for equation, value in parts], axis=0)
        moment = np.sum([equation.moment(place.B) * value for equation, value in parts], axis=0)
        out += _on_both(robot, closure, Wrench(force, moment))
    return np.array(qdd, dtype=float), out


def _on_both(robot: Posed, closure: Closure, acting: Wrench) -> list[tuple[int, Wrench]]:
    """From a wrench on the link at its point, in the axes of the other link: that on both bodies."""
    at, (body, R, p), (other, R_o, _) = robot.at, robot.model.links[closure.loop.link], _end(robot, closure)
    own, to = at.places[body], at.places[other]
    f, n = (to.R @ (R_o @ part) for part in acting)
    x = own.c + own.R @ (p + R @ np.array(closure.loop.point) - robot.system.centres[body])
    out = []
    for i, sign in ((body, 1.0), (other, -1.0)):
        if i >= 0:
            place = at.places[i]
            arm = place.R.T @ (x - place.c) + robot.system.centres[i]
            force = sign * (place.R.T @ f)
            out.append((i, Wrench(force, sign * (place.R.T @ n) + cross(arm, force))))
    return out


def _end(robot: Posed, closure: Closure) -> Frame:
    """The frame of the other link in its body, of the description's own axes."""
    return robot.model.links.get(closure.loop.to, GROUND_FRAME)
