"""What the elimination of reactions leaves: the equations of motion in the coordinates of the joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robodyn.equations.dae.consistent import flat_speeds
from robodyn.equations.dae.posed import Posed, own_rates
from robodyn.equations.dae.solve import Solution
from robodyn.equations.dae.state import accelerations_of, state_of
from robodyn.programs.linear import across, shortest, solve
from robodyn.programs.vectors import narrowed, product
from robodyn.support.floats import Floats

LOOSE = 1e-10
"""Equations of loops of which no more than this part of the largest is left follow from the others."""


@dataclass(frozen=True, eq=False)
class Reduced:
    """What is left after the elimination.

    Attributes:
        J: (6N, n) velocity transformation, v = J qd.
        drift: (6N,) accelerations where qdd = 0.
        M, free: (n, n), (n,) `M qdd = free` with free = J^T (f - M drift), tau less the bias; loops aside.
        G, gamma: (l, n), (l,) of loops, `G qdd = gamma`; no rows without loops.
    """

    J: Floats
    drift: Floats
    M: Floats
    free: Floats
    G: Floats
    gamma: Floats


def reduced(robot: Posed) -> Reduced:
    """J from the motion of the joints, one at a time, and the projections J^T M J and J^T (f - M drift)."""
    J, drift = velocity_transformation(robot), accelerations_at_rest(robot)
    found, rows = robot.matrices, robot.system.tree
    return Reduced(
        J,
        drift,
        product(J.T, found.M, J),
        product(J.T, found.f - product(found.M, drift)),
        product(found.G[rows:], J),
        found.gamma[rows:] - product(found.G[rows:], drift),
    )


def velocity_transformation(robot: Posed) -> Floats:
    """J(q): column k has the speeds of all bodies where coordinate k alone moves, at 1 per second."""
    model, sample = robot.model, robot.sample
    columns = [flat_speeds(state_of(model, robot.system.centres, sample.q, unit)) for unit in np.eye(model.n).tolist()]
    return np.stack(columns, axis=1)


def accelerations_at_rest(robot: Posed) -> Floats:
    """Jdot qd: the accelerations of all bodies where no coordinate accelerates."""
    model, sample = robot.model, robot.sample
    each = accelerations_of(model, robot.system.centres, sample.q, sample.qd, (0.0,) * model.n)
    return narrowed(np.concatenate([part for pair in each for part in pair]))


def independent_accelerations(left: Reduced) -> Floats:
    """qdd of what is left, without the reactions of loops: `qdd = q_p + N z`, `N^T M N z = N^T (free - M q_p)`.

    The columns of N span the motions that loops allow, G N = 0, and G q_p = gamma.
    """
    if not len(left.G):
        return solve(left.M, left.free)
    N, start = across(left.G, LOOSE).T, shortest(left.G, left.gamma, LOOSE)
    z = solve(product(N.T, left.M, N), product(N.T, left.free - product(left.M, start)))
    return np.asarray(start + product(N, z))


def accelerations_along(robot: Posed, solution: Solution) -> Floats:
    """qdd out of the accelerations of the bodies."""
    found = robot.matrices
    return np.array(own_rates(robot.model, robot.system, list(product(found.S, solution.a) + found.sigma)))
