"""The equations of motion at one configuration in DAE form: counted, solved, reduced to the ODE form, compared with it.

1. `system.system_at`: the robot as single bodies (`constraints`: what holds two of them together), M, f, G and gamma.
2. `independent_rows`, `counted`: which constraints are redundant; unknowns, equations, degrees of freedom, index.
3. `solved`: accelerations and reactions at once, `[[M, G^T], [G, 0]] (a, -lambda) = (f, gamma)`.
4. `elimination`: v = J qd, and the reactions go; each step with its residual; both forms held against each other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.loops.closed_start import closed_start
from robodyn.dynamics.plan import plan
from robodyn.equations.dae.constraints import values
from robodyn.equations.dae.elimination import (
    Comparison,
    Reduced,
    Step,
    accelerations_along,
    compared,
    reduced,
    steps,
)
from robodyn.equations.dae.system import Matrices, System, system_at
from robodyn.equations.ode import check_equations
from robodyn.errors import InputError
from robodyn.programs.linear import null_space
from robodyn.programs.vectors import length, narrowed_all
from robodyn.robot.configuration import Values, beyond_limits, configuration, rates
from robodyn.robot.kinematics import Wrench
from robodyn.robot.model import Model
from robodyn.scene.parts import Entry
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats

CONTRADICTED = 1e-8
"""Of the magnitudes that add up."""
DEPENDENT = 1e-10
"""A row is dependent if less than this part of it is left outside the span of the rows before it."""
FULL = 1e-13
"""An eigenvalue counts if it is larger than this part of the largest, in a matrix with a diagonal of ones."""
UNDETERMINED = 1e-8
"""A reaction is undetermined if more than this part of it may change and nothing moves otherwise."""
OPEN = 1e-10
"""Of the robot's size: by so much a loop may be open."""


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


class Residuals(NamedTuple):
    """What the constraints are off by: (m,) g(x) [m, rad] and G v [m/s, rad/s]."""

    places: Floats
    speeds: Floats


class Solution(NamedTuple):
    """(6N,) accelerations (wd, dv/dt) of the bodies, and (m,) reactions [N, N m], 0 for redundant equations."""

    a: Floats
    reactions: Floats


@dataclass(frozen=True, eq=False)
class Dae:
    """The DAE form at a state.

    Attributes:
        system: the robot taken apart, with its matrices.
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

    system: System
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
        InputError: there are no equations, a name is none of a joint, a number is not finite, or loops do not close.

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
        found = dae_at(model, scene, q, speeds, torques)
    apart = float(np.abs(found.residuals.places[found.system.tree :]).max(initial=0.0))
    if apart > OPEN * max(found.system.length, 1.0):
        raise InputError(f"the loops stay {apart:.2g} apart", remedy="look for axes that are not quite parallel")
    return found


def closed_state(model: Model, scene: Scene, at: Values | None, qd: Values) -> tuple[Floats, Floats]:
    """q and qd that close the loops: what is given stays, if the other coordinates alone can close them.

    What is not given (`at` None: nothing) begins at the scene's initial values.

    Raises:
        InputError: the loops do not close near there.

    Accuracy: 1e-13 m or rad, for links of up to a metre.
    """
    q, asked_q = begun(model.coordinates, configuration(model, () if at is None else at), at, scene.initial_q)
    speeds, asked_qd = begun(model.rates, rates(model, qd), qd, scene.initial_qd)
    asked = plan(model, replace(scene, initial_q=asked_q, initial_qd=asked_qd))
    q, speeds = np.split(closed_start(asked, np.concatenate((q, speeds))), [model.nq])
    return q, speeds


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


def dae_at(model: Model, scene: Scene, q: Floats, qd: Floats, tau: Floats) -> Dae:
    """Return the same for arrays: nq coordinates, n velocities and n torques."""
    system = system_at(model, scene, q.tolist(), qd.tolist(), tau.tolist())
    found = system.matrices
    if not all(np.isfinite(part).all() for part in found):
        raise InputError("the equations overflow at this configuration", remedy="smaller numbers", file=model.file)
    residuals = Residuals(values(system.equations, system.at), found.G @ system.at.v)
    # angles count as arcs of the robot's length, and each row has length 1: the rank has then no unit
    rows = found.G * np.tile(np.repeat((1.0 / system.length, 1.0), 3), found.G.shape[1] // 6)
    sizes = np.linalg.norm(rows, axis=1, keepdims=True)
    rows = rows / np.where(sizes > 0.0, sizes, 1.0)
    independent = independent_rows(rows, system.tree)
    left = reduced(system)
    counts = counted(system, rows, independent, left)
    solution = solved(found, independent) if counts.coefficients[2] == counts.size else None
    wrenches: tuple[Wrench, ...] = ()
    qdd = comparison = None
    if solution is not None:
        qdd = accelerations_along(system, solution.a)
        wrenches = tuple(narrowed_all(system.joint_wrenches(*solution)))
        comparison = compared(system, *solution, qdd, wrenches)
    return Dae(
        system,
        q,
        qd,
        tau,
        counts,
        residuals,
        solution,
        qdd,
        wrenches,
        left,
        tuple(steps(system, left, *(solution or (None, np.zeros(0))))),
        comparison,
        (*_contradictions(found, independent, solution), *beyond_limits(model, q), *model.notes),
    )


def independent_rows(rows: Floats, first: int = 0) -> NDArray[np.bool_]:
    """Return which unit rows (m, n) do not follow from those before them: they stop a motion that those allow.

    Args:
        first: so many rows are independent, as those of joints and mimic rules of a tree are.
    """
    motions = null_space(rows[:first], DEPENDENT) if first else np.eye(rows.shape[1])
    independent = np.ones(len(rows), dtype=bool)
    for k in range(first, len(rows)):
        stopped = motions @ rows[k]
        independent[k] = length(stopped) > DEPENDENT
        if independent[k]:
            motions = null_space(stopped[None], 0.0) @ motions
    return independent


def counted(system: System, rows: Floats, independent: NDArray[np.bool_], left: Reduced) -> Counts:
    """Return the counts of a system in a state.

    With r independent rows of G and the mass matrix H of the motions that they leave, the coefficients (M, G^T) of
    accelerations and reactions have the rank r + rank H, and together with (G, 0) r more.
    """
    names = [(c.name, reaction) for c in system.connections for reaction in c.reactions]
    r = int(independent.sum())
    undetermined: list[int] = []
    if r < len(rows):
        vanishing = np.linalg.svd(rows)[0][:, r:]
        undetermined = np.flatnonzero(np.abs(vanishing).max(axis=1) > UNDETERMINED).tolist()
    H = left.motions.T @ left.M @ left.motions
    scale = 1.0 / np.sqrt(np.where(np.diag(H) > 0.0, np.diag(H), 1.0))
    resisting = np.abs(np.linalg.eigvalsh(H * np.outer(scale, scale)))
    laws = r + int((resisting > FULL * resisting.max(initial=0.0)).sum())
    return Counts(
        len(system.inertias),
        len(names),
        r,
        tuple(names[k] for k in np.flatnonzero(~independent)),
        tuple(names[k] for k in undetermined),
        (laws, laws, r + laws),
        rows.shape[1] + r,
    )


def solved(found: Matrices, independent: NDArray[np.bool_]) -> Solution:
    """a and reactions of `M a - G^T reactions = f`, `G a = gamma`, redundant rows of G left out: they have none.

    The matrix [[M, G^T], [G, 0]] of (a, -reactions) is symmetric. What the first solution misses is solved for again:
    so small reactions are as good beside large ones.
    """
    G, n, m = found.G[independent], len(found.f), int(independent.sum())
    K, right = np.block([[found.M, G.T], [G, np.zeros((m, m))]]), np.concatenate((found.f, found.gamma[independent]))
    x = np.linalg.solve(K, right)
    x = x + np.linalg.solve(K, right - K @ x)
    reactions = np.zeros(len(found.G))
    reactions[independent] = -x[n:]
    return Solution(x[:n], reactions)


def _contradictions(found: Matrices, independent: NDArray[np.bool_], solution: Solution | None) -> tuple[str, ...]:
    """What to say where redundant equations do not hold for accelerations."""
    if solution is None or independent.all():
        return ()
    G, gamma = found.G[~independent], found.gamma[~independent]
    off = float(np.abs(G @ solution.a - gamma).max())
    if off <= CONTRADICTED * float((np.abs(G) @ np.abs(solution.a) + np.abs(gamma)).max()):
        return ()
    return (
        f"redundant constraints contradict the others for accelerations by {off:.3g} m/s^2 or rad/s^2: "
        "no motion goes on at these velocities",
    )
