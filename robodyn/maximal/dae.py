"""The equations of motion at one configuration in DAE form, solved, reduced to the ODE form and compared with it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robodyn.dynamics.types import Wrench
from robodyn.equations.jobs import check_equations
from robodyn.errors import InputError
from robodyn.forward import forward_dynamics
from robodyn.maximal.consistent import Residuals, residuals
from robodyn.maximal.coordinates import consistent
from robodyn.maximal.counts import Counts, counted
from robodyn.maximal.elimination import Reduced, Step, accelerations_along, independent_accelerations, reduced, steps
from robodyn.maximal.posed import Posed, posed
from robodyn.maximal.reactions import joint_wrenches, loop_wrenches
from robodyn.maximal.solve import Solution, rank_of, solved
from robodyn.model import Model
from robodyn.plan import loads
from robodyn.robot_inertia.configuration import Values, beyond_limits, configuration, rates
from robodyn.scene import DEFAULT, Scene

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Comparison:
    """Both forms side by side.

    Attributes:
        qdd: (n,) of the ODE form; wrenches: of its recursion of forces, one for each body's joint.
        accelerations: the largest difference as a part of the largest acceleration.
        forces: as a part of the largest force at a joint, on a body, or that moves one; moments: of the largest moment
            at a joint, or of that force at the robot's length.
    """

    qdd: Floats
    wrenches: tuple[Wrench, ...]
    accelerations: float
    forces: float
    moments: float


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
        warnings: coordinates beyond their limits, and what the description leaves to be guessed.
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
    """The DAE form of the equations of motion at a configuration.

    Each of the N bodies has six coordinates and Newton's and Euler's laws about its mass centre; each joint with f
    degrees of freedom has 6 - f constraint equations with as many reactions:
    `[[M, G^T], [G, 0]] (a, -lambda) = (f, gamma)`.

    Args:
        at, qd, tau: by order or by name, the rest zero; a base that moves stands upright at the ground's origin. In a
            scene with loops `at` and `qd` are where the nearest state that closes them is sought, None being the
            scene's initial state.

    Raises:
        InputError: there are no equations, a name is none of a joint, or a number is not finite.

    Accuracy: accelerations and reactions within 1e-12 of the largest of those of the ODE form, for mass matrices of
    condition up to 1e7.
    """
    check_equations(model, scene)
    q, speeds, torques = configuration(model, () if at is None else at), rates(model, qd), rates(model, tau)
    with np.errstate(all="ignore"):
        if scene.loops:
            q, speeds = closed_state(model, scene, q, speeds, at is None)
        return dae_at(model, scene, q, speeds, torques)


def closed_state(model: Model, scene: Scene, q: Floats, qd: Floats, initial: bool) -> tuple[Floats, Floats]:
    """The nearest q and qd that close the loops, sought from those given or from the scene's initial ones."""
    if initial:
        for names, values, start in ((model.coordinates, q, scene.initial_q), (model.rates, qd, scene.initial_qd)):
            values[:] = [start.get(name, value) for name, value in zip(names, values.tolist(), strict=True)]
    return consistent(posed(model, scene, q.tolist(), qd.tolist(), [0.0] * model.n))


def dae_at(model: Model, scene: Scene, q: Floats, qd: Floats, tau: Floats) -> Dae:
    """The same for arrays: nq coordinates, n velocities and n torques."""
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
        wrenches = tuple(joint_wrenches(robot.system, robot.at, found, solution.a, solution.reactions.tolist()))
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
        None if solution is None or qdd is None else _compared(robot, left, solution, qdd, wrenches),
        (*beyond_limits(model, q), *model.notes),
    )


def _compared(robot: Posed, left: Reduced, solution: Solution, qdd: Floats, wrenches: tuple[Wrench, ...]) -> Comparison:
    """The articulated-body recursion and the recursion of forces beside the saddle-point system."""
    model, sample = robot.model, robot.sample
    loops = loop_wrenches(robot.system, robot.at, solution.reactions.tolist())
    if robot.scene.loops:
        ode = independent_accelerations(left)
    else:
        q, qd, tau = (np.array(x, dtype=float) for x in (sample.q, sample.qd, robot.tau))
        ode = forward_dynamics(model, q, qd, tau, scene=robot.scene, executor="numpy")
    terms = replace(robot.terms, qd=sample.qd, qdd=tuple(ode.tolist()), wrenches=(*robot.terms.wrenches, *loops))
    others = tuple(loads(sample, terms).reactions)
    found = robot.matrices
    moved = [part.reshape(-1, 6)[:, 3:] for part in (found.f, found.M @ solution.a)]
    force = max(_largest(part) for part in (*moved, [wrench.f for wrench in others]))
    moment = max(_largest([wrench.n for wrench in others]), force * robot.length)
    return Comparison(
        ode,
        others,
        _difference(qdd, ode, _largest(ode)),
        _difference([wrench.f for wrench in wrenches], [wrench.f for wrench in others], force),
        _difference([wrench.n for wrench in wrenches], [wrench.n for wrench in others], moment),
    )


def _largest(values: ArrayLike) -> float:
    return float(np.abs(np.asarray(values, dtype=float)).max(initial=0.0))


def _difference(one: ArrayLike, other: ArrayLike, scale: float) -> float:
    return _largest(np.asarray(one, dtype=float) - np.asarray(other, dtype=float)) / (scale or 1.0)
