"""From the DAE to the ODE form: the reactions are eliminated by a transformation of velocities, step by step."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robodyn.dynamics.inverse import bias_forces
from robodyn.dynamics.mass import mass_matrix
from robodyn.equations.dae.posed import Posed
from robodyn.equations.dae.solve import Reduced, Solution, accelerations_along, independent_accelerations
from robodyn.programs.vectors import product
from robodyn.support.floats import Floats


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


def steps(robot: Posed, left: Reduced, solution: Solution | None) -> tuple[Step, ...]:
    """Return every step with its identity, held against numbers from elsewhere."""
    found = [*_velocities(robot, left), *_projected(robot, left)]
    return tuple(found) if solution is None else (*found, *_solved(robot, left, solution))


def _velocities(robot: Posed, left: Reduced) -> list[Step]:
    """Return the transformation, and that the reactions of joints go."""
    rows, J = robot.system.tree, left.J
    G, gamma = robot.matrices.G[:rows], robot.matrices.gamma[:rows]
    return [
        _step(
            "velocities of the bodies from those of the joints: they fulfil every joint's constraints by themselves",
            "v = J(q) qd",
            "G J = 0",
            product(G, J),
            0.0,
            product(np.abs(G), np.abs(J)),
        ),
        _step(
            "accelerations likewise",
            "a = J qdd + Jdot qd",
            "G Jdot qd = gamma",
            product(G, left.drift),
            gamma,
            product(np.abs(G), np.abs(left.drift)) + np.abs(gamma),
        ),
        _step(
            "inserted in M a = f + G^T lambda, and multiplied by J^T from the left: the reactions do no work and go",
            "J^T M (J qdd + Jdot qd) = J^T f + J^T G^T lambda",
            "J^T G^T = 0",
            product(J.T, G.T),
            0.0,
            product(np.abs(J.T), np.abs(G.T)),
        ),
    ]


def _projected(robot: Posed, left: Reduced) -> list[Step]:
    """Return what is left, beside the mass matrix and the bias of the recursions."""
    model, scene, J = robot.model, replace(robot.scene, loops=()), left.J
    q, qd, tau = (np.array(x, dtype=float) for x in (robot.sample.q, robot.sample.qd, robot.tau))
    return [
        _step(
            "the masses of the bodies become the mass matrix",
            "J^T M J = M(q)",
            "J^T M J against M(q) of the recursion",
            left.M,
            mass_matrix(model, q, scene=scene, executor="numpy"),
            product(np.abs(J.T), np.abs(robot.matrices.M), np.abs(J)),
        ),
        _step(
            "the forces become torques less the bias",
            "J^T (f - M Jdot qd) = tau - bias(q, qd)",
            "against bias(q, qd) of the recursion",
            left.free,
            tau - bias_forces(model, q, qd, scene=scene, executor="numpy"),
            _sizes(robot, left),
        ),
    ]


def _solved(robot: Posed, left: Reduced, solution: Solution) -> list[Step]:
    """Return the solution of the DAE put into the equations that are left."""
    found, qdd = robot.matrices, accelerations_along(robot, solution)
    a = product(left.J, qdd) + left.drift
    back = _step(
        "back to the reactions, where they are asked for",
        "G^T lambda = M a - f",
        "with qdd of the ODE form and lambda of the DAE",
        product(found.G.T, solution.reactions),
        product(found.M, a) - found.f,
        product(np.abs(found.M), np.abs(a)) + np.abs(found.f),
    )
    ode = _with_loops if robot.system.loops else _without_loops
    return [*ode(robot, left, solution, qdd), back]


def _without_loops(robot: Posed, left: Reduced, solution: Solution, qdd: Floats) -> list[Step]:
    return [
        _step(
            "the ODE form",
            "M(q) qdd = tau - bias(q, qd)",
            "with qdd of the DAE",
            product(left.M, qdd),
            left.free,
            product(np.abs(left.M), np.abs(qdd)) + _sizes(robot, left),
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
            product(left.M, qdd),
            left.free + product(left.G.T, loops),
            product(np.abs(left.M), np.abs(qdd)) + product(np.abs(left.G.T), np.abs(loops)) + _sizes(robot, left),
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
    sizes: Floats = product(np.abs(left.J.T), np.abs(found.f) + product(np.abs(found.M), np.abs(left.drift)))
    return sizes


def _step(title: str, formula: str, checks: str, one: Floats, other: Floats | float, sizes: Floats) -> Step:
    scale = float(np.max(sizes, initial=0.0))
    difference = float(np.max(np.abs(one - other), initial=0.0))
    return Step(title, formula, checks, difference / scale if scale else difference, scale)
