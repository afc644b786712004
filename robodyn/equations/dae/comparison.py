"""The DAE form beside the ODE form: the same accelerations, the same forces and moments at the joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robodyn.dynamics.forward import forward_dynamics
from robodyn.dynamics.plan import loads
from robodyn.equations.dae.closed import by_the_tree
from robodyn.equations.dae.posed import Posed
from robodyn.equations.dae.rank import Rank
from robodyn.equations.dae.solve import Solution
from robodyn.programs.vectors import narrowed_all, product
from robodyn.robot.motion_types import Wrench

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Comparison:
    """Both forms side by side.

    Attributes:
        qdd: (n,) of the ODE form; wrenches: of its recursion of forces, one for each body's joint.
        accelerations: the largest difference as a part of the largest acceleration, those of bodies and of free fall
            among them.
        forces: as a part of the largest force at a joint, on a body, or that moves one; moments: of the largest moment
            at a joint, or of that force at the robot's length.
    """

    qdd: Floats
    wrenches: tuple[Wrench, ...]
    accelerations: float
    forces: float
    moments: float


def compared(robot: Posed, rank: Rank, solution: Solution, qdd: Floats, wrenches: Sequence[Wrench]) -> Comparison:
    """The solution of the saddle-point system beside what recursions make of the same state.

    qdd by articulated bodies, or with loops by `robodyn.dynamics.loops`; then the recursion of forces, with the
    reactions of loops as loads: those of `robodyn.dynamics.loops`, but where rigid bodies leave these open, those of
    the DAE.
    """
    model, sample = robot.model, robot.sample
    loops: Sequence[tuple[int, Wrench]] = ()
    if robot.scene.loops:
        ode, loops = by_the_tree(robot, len(rank.independent) - robot.system.tree, solution)
    else:
        q, qd, tau = (np.array(x, dtype=float) for x in (sample.q, sample.qd, robot.tau))
        ode = forward_dynamics(model, q, qd, tau, scene=robot.scene, executor="numpy")
    terms = replace(robot.terms, qd=sample.qd, qdd=tuple(ode.tolist()), wrenches=(*robot.terms.wrenches, *loops))
    others = tuple(narrowed_all(loads(sample, terms).reactions))
    found = robot.matrices
    moved = [part.reshape(-1, 6)[:, 3:] for part in (found.f, product(found.M, solution.a))]
    force = max(_largest(part) for part in (*moved, [wrench.f for wrench in others]))
    moment = max(_largest([wrench.n for wrench in others]), force * robot.length)
    return Comparison(
        ode,
        others,
        _difference(qdd, ode, max(_largest(part) for part in (ode, solution.a, robot.scene.gravity))),
        _difference([wrench.f for wrench in wrenches], [wrench.f for wrench in others], force),
        _difference([wrench.n for wrench in wrenches], [wrench.n for wrench in others], moment),
    )


def _largest(values: ArrayLike) -> float:
    return float(np.abs(np.asarray(values, dtype=float)).max(initial=0.0))


def _difference(one: ArrayLike, other: ArrayLike, scale: float) -> float:
    return _largest(np.asarray(one, dtype=float) - np.asarray(other, dtype=float)) / (scale or 1.0)
