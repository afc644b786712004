"""From the DAE to the ODE form: the reactions are eliminated by a transformation of velocities, step by step."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from robodyn.inverse import bias_forces, mass_matrix
from robodyn.maximal.consistent import flat_speeds
from robodyn.maximal.posed import Posed, own_rates
from robodyn.maximal.solve import Solution
from robodyn.maximal.state import accelerations_of, state_of

Floats = NDArray[np.float64]
LOOSE = 1e-10
"""Equations of loops whose singular value is a smaller part of the largest follow from the others."""


@dataclass(frozen=True)
class Step:
    """One step of the elimination.

    Attributes:
        title: what is done; formula: what then holds; checks: what was computed twice.
        error: the largest difference, as a part of `scale`.
        scale: the largest sum of magnitudes that add up to a number compared.
    """

    title: str
    formula: str
    checks: str
    error: float
    scale: float


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
        J.T @ found.M @ J,
        J.T @ (found.f - found.M @ drift),
        found.G[rows:] @ J,
        found.gamma[rows:] - found.G[rows:] @ drift,
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
    return np.concatenate([part for pair in each for part in pair])


def steps(robot: Posed, left: Reduced, solution: Solution | None) -> tuple[Step, ...]:
    """Every step with its identity, held against numbers from elsewhere."""
    model, found, rows = robot.model, robot.matrices, robot.system.tree
    scene = replace(robot.scene, loops=())
    q, qd, tau = (np.array(x, dtype=float) for x in (robot.sample.q, robot.sample.qd, robot.tau))
    G, gamma, J = found.G[:rows], found.gamma[:rows], left.J
    M = mass_matrix(model, q, scene=scene, executor="numpy")
    bias = bias_forces(model, q, qd, scene=scene, executor="numpy")
    out = [
        _step(
            "velocities of the bodies from those of the joints: they fulfil every joint's constraints by themselves",
            "v = J(q) qd",
            "G J = 0",
            G @ J,
            0.0,
            np.abs(G) @ np.abs(J),
        ),
        _step(
            "accelerations likewise",
            "a = J qdd + Jdot qd",
            "G Jdot qd = gamma",
            G @ left.drift,
            gamma,
            np.abs(G) @ np.abs(left.drift) + np.abs(gamma),
        ),
        _step(
            "inserted in M a = f + G^T lambda, and multiplied by J^T from the left: the reactions do no work and go",
            "J^T M (J qdd + Jdot qd) = J^T f + J^T G^T lambda",
            "J^T G^T = 0",
            J.T @ G.T,
            0.0,
            np.abs(J.T) @ np.abs(G.T),
        ),
        _step(
            "the masses of the bodies become the mass matrix",
            "J^T M J = M(q)",
            "J^T M J against M(q) of the recursion",
            left.M,
            M,
            np.abs(J.T) @ np.abs(found.M) @ np.abs(J),
        ),
        _step(
            "the forces become torques less the bias",
            "J^T (f - M Jdot qd) = tau - bias(q, qd)",
            "against bias(q, qd) of the recursion",
            left.free,
            tau - bias,
            _sizes(robot, left),
        ),
    ]
    return tuple(out) if solution is None else (*out, *_solved(robot, left, solution))


def independent_accelerations(left: Reduced) -> Floats:
    """qdd of what is left, without the reactions of loops: `qdd = q_p + N z`, `N^T M N z = N^T (free - M q_p)`.

    The columns of N span the motions that loops allow, G N = 0, and G q_p = gamma.
    """
    if not len(left.G):
        return np.asarray(np.linalg.solve(left.M, left.free))
    _, sizes, V = np.linalg.svd(left.G)
    N = V[int((sizes > LOOSE * sizes[0]).sum()) :].T
    start = np.linalg.lstsq(left.G, left.gamma, rcond=LOOSE)[0]
    z = np.linalg.solve(N.T @ left.M @ N, N.T @ (left.free - left.M @ start))
    return np.asarray(start + N @ z)


def _solved(robot: Posed, left: Reduced, solution: Solution) -> list[Step]:
    """The solution of the DAE put into the equations that are left."""
    found, qdd = robot.matrices, accelerations_along(robot, solution)
    a = left.J @ qdd + left.drift
    back = _step(
        "back to the reactions, where they are asked for",
        "G^T lambda = M a - f",
        "with qdd of the ODE form and lambda of the DAE",
        found.G.T @ solution.reactions,
        found.M @ a - found.f,
        np.abs(found.M) @ np.abs(a) + np.abs(found.f),
    )
    ode = _with_loops if robot.system.loops else _without_loops
    return [*ode(robot, left, solution, qdd), back]


def _without_loops(robot: Posed, left: Reduced, solution: Solution, qdd: Floats) -> list[Step]:
    return [
        _step(
            "the ODE form",
            "M(q) qdd = tau - bias(q, qd)",
            "with qdd of the DAE",
            left.M @ qdd,
            left.free,
            np.abs(left.M) @ np.abs(qdd) + _sizes(robot, left),
        )
    ]


def _with_loops(robot: Posed, left: Reduced, solution: Solution, qdd: Floats) -> list[Step]:
    loops = solution.reactions[robot.system.tree :]
    own = independent_accelerations(left)
    start = np.abs(left.drift).max(initial=0.0)
    return [
        _step(
            "what is left: loops keep their reactions, with G_l = G J",
            "M(q) qdd = tau - bias(q, qd) + G_l^T lambda_l,  G_l qdd = gamma_l",
            "with qdd and lambda of the DAE",
            left.M @ qdd,
            left.free + left.G.T @ loops,
            np.abs(left.M) @ np.abs(qdd) + np.abs(left.G.T) @ np.abs(loops) + _sizes(robot, left),
        ),
        _step(
            "the motions that the loops leave, G_l N = 0: their reactions go too",
            "qdd = q_p + N z,  N^T M N z = N^T (tau - bias - M q_p)",
            "qdd of these against that of the DAE",
            own,
            qdd,
            np.abs(qdd) + start,
        ),
    ]


def _sizes(robot: Posed, left: Reduced) -> Floats:
    """Of what adds up to J^T (f - M drift)."""
    found = robot.matrices
    sizes: Floats = np.abs(left.J.T) @ (np.abs(found.f) + np.abs(found.M) @ np.abs(left.drift))
    return sizes


def accelerations_along(robot: Posed, solution: Solution) -> Floats:
    """qdd out of the accelerations of the bodies."""
    found = robot.matrices
    return np.array(own_rates(robot.model, robot.system, list(found.S @ solution.a + found.sigma)))


def _step(title: str, formula: str, checks: str, one: Floats, other: Floats | float, sizes: Floats) -> Step:
    scale = float(np.max(sizes, initial=0.0))
    difference = float(np.max(np.abs(one - other), initial=0.0))
    return Step(title, formula, checks, difference / scale if scale else difference, scale)
