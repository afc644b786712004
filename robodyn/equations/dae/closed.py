"""Closed chains: where they close, and what the tree's equations with loops make of the same state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from robodyn.dynamics.loops.closed_chain import closed_chain
from robodyn.dynamics.loops.closed_start import closed_start
from robodyn.dynamics.loops.closure import GROUND_FRAME, Closure
from robodyn.dynamics.plan import applied, plan
from robodyn.equations.dae.consistent import flat_speeds, projected
from robodyn.equations.dae.equations import stacked, values
from robodyn.equations.dae.posed import Posed, own_rates, posed
from robodyn.equations.dae.solve import Solution
from robodyn.equations.dae.state import State
from robodyn.equations.dae.system import loop_wrenches
from robodyn.equations.ode import bias_plan
from robodyn.programs.vectors import cross, product
from robodyn.robot.configuration import Values, configuration, rates
from robodyn.robot.kinematics import Wrench
from robodyn.robot.model import Model
from robodyn.scene.parts import Entry
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats, first_largest


def coordinates_of(robot: Posed, at: State) -> tuple[Floats, Floats]:
    """q and qd of the joints where the bodies are as in `at`, whose places fulfil the joints' constraints.

    A hinge's turn is the one nearest to that of `robot`; mimic joints are left to their leaders.
    """
    model, system = robot.model, robot.system
    qd = own_rates(model, system, product(stacked(system.free, at), flat_speeds(at)).tolist())
    q = np.zeros(model.nq)
    for i, (body, connection) in enumerate(zip(model.bodies, system.joints, strict=True)):
        joint = body.joint
        if joint.kind == "floating":
            R_o = at.places[body.parent].R if body.parent >= 0 else np.eye(3)
            turn = product(joint.R.T, R_o.T, at.places[i].R)
            q[joint.coordinate : joint.coordinate + 7] = [*values(connection.free[3:], at), *quaternion(turn)]
        elif joint.kind != "fixed" and joint.mimics is None:
            q[joint.coordinate] = connection.free[0].value(at)
    return q, np.array(qd)


def quaternion(R: Floats) -> Floats:
    """(x, y, z, w) with w >= 0 of a rotation, by its largest component.

    Source: Shepperd, *Quaternion from rotation matrix* (1978).
    """
    squares = np.array([*(1.0 + 2.0 * np.diag(R) - np.trace(R)), 1.0 + np.trace(R)])
    k = first_largest(squares)
    h = np.empty(4)
    h[3] = squares[3]
    if k == 3:
        h[:3] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    else:
        i, j = (k + 1) % 3, (k + 2) % 3
        h[k], h[i], h[j], h[3] = squares[k], R[i, k] + R[k, i], R[j, k] + R[k, j], R[j, i] - R[i, j]
    h = h / np.sqrt(product(h, h))
    if abs(h[3]) <= 1e-15:  # half a turn: the largest component is positive, whichever sign rounding gives w
        h[3] = 0.0
    found: Floats = -h if h[3] < 0.0 else h
    return found


def consistent(robot: Posed) -> tuple[Floats, Floats]:
    """q and qd near those of `robot` that fulfil all constraints, loops too; see `consistent.projected`.

    Raises:
        InputError: there are none nearby.
    """
    return coordinates_of(robot, projected(robot.system, robot.at, robot.length))


def closed_state(model: Model, scene: Scene, at: Values | None, qd: Values) -> tuple[Floats, Floats]:
    """q and qd that close the loops: what is given stays, if the other coordinates alone can close them.

    What is not given begins at the scene's initial values.

    Args:
        at, qd: by order or by name; None for the scene's initial positions.

    Raises:
        InputError: the loops do not close near there.

    Accuracy: all constraints of the single bodies within 1e-14 of the robot's extent.
    """
    q, asked_q = begun(model.coordinates, configuration(model, () if at is None else at), at, scene.initial_q)
    speeds, asked_qd = begun(model.rates, rates(model, qd), qd, scene.initial_qd)
    asked = plan(model, replace(scene, initial_q=asked_q, initial_qd=asked_qd))
    q, speeds = np.split(closed_start(asked, np.concatenate((q, speeds))), [model.nq])
    return consistent(posed(model, scene, q.tolist(), speeds.tolist(), [0.0] * model.n))


def begun(
    names: tuple[str, ...], values: Floats, given: Values | None, start: Mapping[str, Entry]
) -> tuple[Floats, dict[str, Entry]]:
    """Return where the search begins, and what is to stay: what is given, or else the scene's initial values."""
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

    Where equations that it keeps depend on each other, what each loop carries is not determined; then it is what
    `solution` says.

    Args:
        rank: of the loops' equations.
    """
    chain = closed_chain(plan(robot.model, robot.scene))
    sample = replace(robot.sample, model=chain.model)
    terms = applied(bias_plan(robot.model, robot.scene).effects, sample, robot.scene)
    qdd, multipliers = chain.accelerations(sample, terms, list(robot.tau))
    if chain.count > rank:
        return np.array(qdd, dtype=float), loop_wrenches(robot.system, robot.at, solution.reactions.tolist())
    wrenches = chain.wrenches(chain.equations(sample), multipliers)
    each = [_on_both(robot, *pair) for pair in zip(chain.closures, wrenches, strict=True)]
    return np.array(qdd, dtype=float), [pair for both in each for pair in both]


def _on_both(robot: Posed, closure: Closure, acting: Wrench) -> list[tuple[int, Wrench]]:
    """From a wrench on the link at its point, in the axes of the other link: that on both bodies."""
    at, links = robot.at, robot.model.links
    (body, R, p), (other, R_o, _) = links[closure.loop.link], links.get(closure.loop.to, GROUND_FRAME)
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
