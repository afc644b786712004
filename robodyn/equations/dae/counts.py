"""How many unknowns and equations there are, from ranks; and the DAE form held against the ODE form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.forward import forward_dynamics
from robodyn.dynamics.plan import loads
from robodyn.equations.dae.closed import by_the_tree
from robodyn.equations.dae.posed import Posed
from robodyn.equations.dae.solve import Rank, Solution, equilibrated, saddle, scaled_rows
from robodyn.equations.dae.system import Matrices, System
from robodyn.programs.vectors import narrowed_all, product
from robodyn.robot.kinematics import Wrench
from robodyn.support.floats import Floats

FULL = 1e-13
"""An eigenvalue counts if it is larger than this part of the largest, in a matrix of like rows and columns."""
UNDETERMINED = 1e-8
"""A reaction is undetermined if more than this part of it may change and nothing moves otherwise."""


@dataclass(frozen=True)
class Counts:
    """Unknowns, equations and ranks.

    Attributes:
        bodies: N; there are 6 N positions and 6 N velocities.
        reactions: m, the algebraic unknowns, one for each constraint equation.
        rank: of G.
        redundant: the equations that follow from those before them, as (connection, reaction) names.
        undetermined: the reactions that rigid bodies leave open, likewise.
        coefficients: ranks of the coefficients of accelerations and reactions, with constraints on positions,
            velocities and accelerations, redundant ones left out; `size` is the number of these unknowns.
    """

    bodies: int
    reactions: int
    rank: int
    redundant: tuple[tuple[str, str], ...]
    undetermined: tuple[tuple[str, str], ...]
    coefficients: tuple[int, int, int]
    size: int

    @property
    def freedom(self) -> int:
        """6 N - rank G."""
        return 6 * self.bodies - self.rank

    @property
    def unknowns(self) -> int:
        """Positions, velocities and reactions; there are as many equations."""
        return 12 * self.bodies + self.reactions

    @property
    def index(self) -> tuple[int, int, int] | None:
        """The differentiation index with constraints on positions, velocities and accelerations.

        The constraints are differentiated until accelerations and reactions follow from the equations; once more, and
        these are differential equations for the reactions too. Without reactions they are one to begin with. None where
        nothing resists some motion: no differentiation helps.
        """
        if not self.reactions:
            return (0, 0, 0)
        times = next((k for k, rank in enumerate(self.coefficients) if rank == self.size), None)
        if times is None:
            return None
        first, second, third = (max(times - level, 0) + 1 for level in range(3))
        return first, second, third


def counted(system: System, found: Matrices, rank: Rank, length: float) -> Counts:
    """Return the counts of a system in a state."""
    names = [(c.name, reaction) for c in system.connections for reaction in c.reactions]
    G = found.G[rank.independent]
    n = len(found.f)
    K = equilibrated(saddle(found.M, G))[0]
    laws = _rank(product(K[:n], K[:n].T))
    return Counts(
        len(system.inertias),
        len(names),
        len(rank.independent),
        tuple(names[k] for k in rank.dependent),
        tuple(names[k] for k in _undetermined(found.G, rank, length)),
        (laws, laws, _rank(K)),
        len(K),
    )


def _rank(K: Floats) -> int:
    """Of a symmetric matrix."""
    sizes = np.abs(np.linalg.eigvalsh(K))
    return int((sizes > FULL * sizes.max()).sum())


def _undetermined(G: Floats, rank: Rank, length: float) -> list[int]:
    """Return rows that take part in a combination of rows that vanishes."""
    if not len(rank.dependent):
        return []
    rows = scaled_rows(G, length)
    left = np.linalg.svd(rows)[0][:, len(rank.independent) :]
    return [int(k) for k in np.flatnonzero(np.abs(left).max(axis=1) > UNDETERMINED)]


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
    """Return the solution of the saddle-point system beside what recursions make of the same state.

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
