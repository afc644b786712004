"""The equations of motion at one configuration in DAE form, solved, reduced to the ODE form and compared with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robodyn.equations.dae.closed import closed_state
from robodyn.equations.dae.consistent import Residuals, residuals
from robodyn.equations.dae.counts import Comparison, Counts, compared, counted
from robodyn.equations.dae.elimination import Step, steps
from robodyn.equations.dae.posed import Posed, posed
from robodyn.equations.dae.solve import Rank, Reduced, Solution, accelerations_along, rank_of, reduced, solved
from robodyn.equations.dae.system import Matrices, joint_wrenches
from robodyn.equations.ode import check_equations
from robodyn.errors import InputError
from robodyn.programs.vectors import narrowed_all, product
from robodyn.robot.configuration import Values, beyond_limits, configuration, rates
from robodyn.robot.kinematics import Wrench
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats

CONTRADICTED = 1e-8
"""Of the magnitudes that add up."""


@dataclass(frozen=True, eq=False)
class Dae:
    """The DAE form at a state.

    Attributes:
        robot: taken apart, with its matrices.
        q, qd, tau: the state, and what drives it.
        counts: unknowns, equations, ranks, index.
        residuals: of positions and velocities.
        solution: accelerations and reactions, None where nothing resists some motion.
        qdd: (n,) accelerations of the coordinates; wrenches: what each body's parent exerts on it.
        steps: of the elimination; reduced: what is left.
        comparison: with the ODE form.
        warnings: redundant constraints that contradict the others, coordinates beyond their limits, and what the
            description leaves to be guessed.
    """

    robot: Posed
    q: Floats
    qd: Floats
    tau: Floats
    counts: Counts
    residuals: Residuals
    solution: Solution | None
    qdd: Floats | None
    wrenches: tuple[Wrench, ...]
    reduced: Reduced
    steps: tuple[Step, ...]
    comparison: Comparison | None
    warnings: tuple[str, ...]


def dae(model: Model, scene: Scene = DEFAULT, at: Values | None = None, qd: Values = (), tau: Values = ()) -> Dae:
    """Return the DAE form of the equations of motion at a configuration.

    Each of the N bodies has six coordinates and Newton's and Euler's laws about its mass centre; each joint with f
    degrees of freedom has 6 - f constraint equations with as many reactions:
    `[[M, G^T], [G, 0]] (a, -lambda) = (f, gamma)`.

    Args:
        at, qd, tau: by order or by name, the rest zero; a base that moves stands upright at the ground's origin. Where
            the scene has loops, the rest begins at the scene's initial values and moves so that the loops close.

    Raises:
        InputError: there are no equations, a name is none of a joint, or a number is not finite.

    Accuracy: accelerations and reactions within 1e-12 of the largest of those of the ODE form, for mass matrices of
    condition up to 1e7.
    """
    check_equations(model, scene)
    torques = rates(model, tau)
    with np.errstate(all="ignore"):
        if scene.loops:
            q, speeds = closed_state(model, scene, at, qd)
        else:
            q, speeds = configuration(model, () if at is None else at), rates(model, qd)
        return dae_at(model, scene, q, speeds, torques)


def dae_at(model: Model, scene: Scene, q: Floats, qd: Floats, tau: Floats) -> Dae:
    """Return the same for arrays: nq coordinates, n velocities and n torques."""
    robot = posed(model, scene, q.tolist(), qd.tolist(), tau.tolist())
    found = robot.matrices
    if not all(np.isfinite(part).all() for part in found):
        raise InputError("the equations overflow at this configuration", remedy="smaller numbers", file=model.file)
    rank = rank_of(found.G, robot.length)
    solution = solved(found, rank)
    left = reduced(robot)
    qdd = None if solution is None else accelerations_along(robot, solution)
    wrenches: tuple[Wrench, ...] = ()
    if solution is not None:
        wrenches = tuple(
            narrowed_all(joint_wrenches(robot.system, robot.at, found, solution.a, solution.reactions.tolist()))
        )
    return Dae(
        robot,
        q,
        qd,
        tau,
        counted(robot.system, found, rank, robot.length),
        residuals(robot.system, robot.at),
        solution,
        qdd,
        wrenches,
        left,
        steps(robot, left, solution),
        None if solution is None or qdd is None else compared(robot, rank, solution, qdd, wrenches),
        (*contradictions(found, rank, solution), *beyond_limits(model, q), *model.notes),
    )


def contradictions(found: Matrices, rank: Rank, solution: Solution | None) -> tuple[str, ...]:
    """What to say where redundant equations, which held for positions and velocities, do not for accelerations."""
    rows = rank.dependent
    if solution is None or not len(rows):
        return ()
    G, gamma = found.G[rows], found.gamma[rows]
    off = float(np.abs(product(G, solution.a) - gamma).max())
    if off <= CONTRADICTED * float((product(np.abs(G), np.abs(solution.a)) + np.abs(gamma)).max()):
        return ()
    return (
        f"redundant constraints contradict the others for accelerations by {off:.3g} m/s^2 or rad/s^2: "
        "no motion goes on at these velocities",
    )
