"""What each joint does to the body that it carries, from the reactions of the saddle-point system."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robodyn.equations.dae.equations import Equation
from robodyn.equations.dae.state import State
from robodyn.equations.dae.system import Matrices, System
from robodyn.programs.vectors import Array, Scalar, cross, product
from robodyn.robot.motion_types import Wrench


def joint_wrenches(system: System, at: State, found: Matrices, a: Array, reactions: Sequence[Scalar]) -> list[Wrench]:
    """The force and moment that each body's parent exerts on it, about its origin in its axes, drives included.

    The reactions of its joint's equations; along the joint's coordinates what acts there, less `J (S a + sigma)` for a
    rotor, and the reactions of the mimic rules that it takes part in.

    Args:
        a: (6N,) accelerations of the bodies.
        reactions: (m,) in the order of the rows of G.
    """
    own: dict[int, Scalar] = {}
    start = sum(len(joint.equations) for joint in system.joints)
    for k, rule in enumerate(system.rules, start):
        for weight, term in rule.terms:
            own[id(term)] = own.get(id(term), 0.0) + weight * reactions[k]
    along = found.along - found.armature * (product(found.S, a) + found.sigma)
    out, row, k = [], 0, 0
    for i, joint in enumerate(system.joints):
        acting = [(equation, reactions[row + j]) for j, equation in enumerate(joint.equations)]
        acting += [(term, along[k + j] + own.get(id(term), 0.0)) for j, term in enumerate(joint.free)]
        row, k = row + len(joint.equations), k + len(joint.free)
        out.append(_about_origin(system, at, i, acting))
    return out


def loop_wrenches(system: System, at: State, reactions: Sequence[Scalar]) -> list[tuple[int, Wrench]]:
    """(i, wrench) pairs: what the closure of each loop does to both its bodies, the ground aside, about their origins.

    Args:
        reactions: (m,) in the order of the rows of G.
    """
    out, row = [], 0
    for connection in system.connections:
        size = len(connection.equations)
        if connection in system.loops:
            acting = list(zip(connection.equations, reactions[row : row + size], strict=True))
            ends = [i for i in (connection.body, connection.other) if i >= 0]
            out += [(i, _about_origin(system, at, i, acting)) for i in ends]
        row += size
    return out


def _about_origin(system: System, at: State, i: int, acting: Sequence[tuple[Equation, Scalar]]) -> Wrench:
    total = wrench_on(i, acting, at)
    f = at.places[i].R.T @ total[3:]
    return Wrench(f, total[:3] + cross(system.centres[i], f))


def wrench_on(body: int, acting: Sequence[tuple[Equation, Scalar]], at: State) -> Array:
    """What multipliers of equations do to a body: moment about its mass centre (its axes) and force (ground's)."""
    total: Array = np.zeros(6)
    for equation, multiplier in acting:
        for other, entries in equation.row(at):
            if other == body:
                total = total + entries * multiplier
    return total
