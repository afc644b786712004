"""The equations of motion at one configuration in DAE form: counted, solved, reduced to the ODE form, compared with it.

1. `system.system_at`: the robot as single bodies, M, f, G and gamma.
2. `independent_rows`, `counted`: which constraints are redundant; unknowns, equations, degrees of freedom, index.
3. `solved`: accelerations and reactions at once, `[[M, G^T], [G, 0]] (a, -lambda) = (f, gamma)`.
4. `reduced`, `steps`: v = J qd, and the reactions go; each step with its residual. `compared`: both forms.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robodyn.dynamics.forward import forward_dynamics
from robodyn.dynamics.initial_state import closed_start
from robodyn.dynamics.inverse import bias_forces, mass_matrix
from robodyn.dynamics.loops.closed_chain import closed_chain
from robodyn.dynamics.plan import applied, loads, plan
from robodyn.equations.dae.system import Matrices, System, state_of, system_at, velocities_of
from robodyn.equations.ode import bias_plan, check_equations
from robodyn.errors import InputError
from robodyn.programs.vectors import length, narrowed, narrowed_all
from robodyn.robot.kinematics import (
    Values,
    Wrench,
    acceleration_of_point,
    accelerations,
    beyond_limits,
    configuration,
    poses,
    rates,
    velocities,
)
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Entry, Scene
from robodyn.support.floats import Floats
from robodyn.support.linear import min_norm_solution, null_space

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
LOOSE = 1e-10
"""Equations of loops of which no more than this part of the largest is left follow from the others."""
VANISHING = 1e-25
"""What rounding leaves of magnitudes that are all zero: nothing is measured by them."""


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
        return 6 * self.bodies - self.rank

    @property
    def unknowns(self) -> int:
        """Positions, velocities and reactions; there are as many equations."""
        return 12 * self.bodies + self.reactions

    @property
    def index(self) -> tuple[int, int, int] | None:
        """The differentiation index with constraints on positions, velocities and accelerations.

        Constraints on accelerations determine accelerations and reactions; differentiated once more they are
        differential equations for the reactions too. Without reactions they are one to begin with. None where nothing
        resists some motion: no differentiation helps.
        """
        if not self.reactions:
            return (0, 0, 0)
        return (3, 2, 1) if self.coefficients[2] == self.size else None


class Residuals(NamedTuple):
    """What the constraints are off by: (m,) g(x) [m, rad] and G v [m/s, rad/s]."""

    places: Floats
    speeds: Floats


class Solution(NamedTuple):
    """(6N,) accelerations (wd, dv/dt) of the bodies, and (m,) reactions [N, N m], 0 for redundant equations."""

    a: Floats
    reactions: Floats


@dataclass(frozen=True, eq=False)
class Reduced:
    """What is left after the elimination.

    Attributes:
        J: (6N, n) velocity transformation, v = J qd.
        drift: (6N,) accelerations where qdd = 0, Jdot qd.
        M, free: (n, n), (n,) `M qdd = free` with free = J^T (f - M drift), tau less the bias; loops aside.
        G, gamma: (l, n), (l,) of loops, `G qdd = gamma`; no rows without loops.
    """

    J: Floats
    drift: Floats
    M: Floats
    free: Floats
    G: Floats
    gamma: Floats

    @property
    def motions(self) -> Floats:
        """(n, k) N, whose columns span the motions that the loops allow, G N = 0."""
        return null_space(self.G, LOOSE).T if len(self.G) else np.eye(len(self.M))

    def accelerations(self) -> Floats:
        """qdd without the reactions of loops: `qdd = q_p + N z`, `G q_p = gamma`, `N^T M N z = N^T (free - M q_p)`."""
        N = self.motions
        start = min_norm_solution(self.G, self.gamma, LOOSE) if len(self.G) else np.zeros(len(self.M))
        return np.asarray(start + N @ np.linalg.solve(N.T @ self.M @ N, N.T @ (self.free - self.M @ start)))


@dataclass(frozen=True)
class Step:
    """One step of the elimination: what is done, what then holds, what was computed twice, and the largest difference
    as a part of `scale`, the largest sum of magnitudes that add up to a number."""

    title: str
    formula: str
    checks: str
    error: float
    scale: float


@dataclass(frozen=True, eq=False)
class Comparison:
    """qdd (n,) of the ODE form, and the largest differences: of accelerations as a part of the largest, those of bodies
    and of free fall among them; of forces, of the largest at a joint, on a body, or that moves one; of moments, of the
    largest at a joint, or of that force at the robot's length."""

    qdd: Floats
    accelerations: float
    forces: float
    moments: float


@dataclass(frozen=True, eq=False)
class Dae:
    """The DAE form at a state.

    Attributes:
        solution: accelerations and reactions, None where nothing resists some motion.
        qdd: (n,) accelerations of the coordinates; wrenches: what each body's parent exerts on it.
        steps: of the elimination; reduced: what is left; comparison: with the ODE form.
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
    apart = _largest(found.residuals.places[found.system.tree :])
    if apart > OPEN * max(found.system.length, 1.0):
        raise InputError(f"the loops stay {apart:.2g} apart", remedy="look for axes that are not quite parallel")
    return found


def closed_state(model: Model, scene: Scene, at: Values | None, qd: Values) -> tuple[Floats, Floats]:
    """q and qd that close the loops: what is given stays, if the other coordinates alone can close them. What is not
    given (`at` None: nothing) begins at the scene's initial values. InputError where the loops do not close near there.
    Accuracy: 1e-13 m or rad, for links of up to a metre."""
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
    apart = np.array([equation.value(system.at) for equation in system.equations], dtype=float)
    residuals = Residuals(apart, found.G @ velocities_of(system.at))
    # angles count as arcs of the robot's length, and each row has length 1: the rank has then no unit
    rows = found.G * np.tile(np.repeat((1.0 / system.length, 1.0), 3), found.G.shape[1] // 6)
    sizes = np.linalg.norm(rows, axis=1, keepdims=True)
    rows = rows / np.where(sizes > 0.0, sizes, 1.0)
    independent, left = independent_rows(rows, system.tree), reduced(system)
    counts = counted(system, rows, independent, left)
    solution = qdd = comparison = None
    wrenches: tuple[Wrench, ...] = ()
    if counts.coefficients[2] == counts.size:
        solution = solved(found, independent)
        qdd = accelerations_along(system, solution.a)
        wrenches = tuple(narrowed_all(system.joint_wrenches(*solution)))
        comparison = compared(system, solution, qdd, wrenches)
    warnings = [*beyond_limits(model, q), *model.notes]
    if solution is not None and not independent.all():
        G, gamma = found.G[~independent], found.gamma[~independent]
        off = _largest(G @ solution.a - gamma)
        if off > CONTRADICTED * _largest(np.abs(G) @ np.abs(solution.a) + np.abs(gamma)):
            warnings.insert(
                0,
                f"redundant constraints contradict the others for accelerations by {off:.3g} m/s^2 or rad/s^2: "
                "no motion goes on at these velocities",
            )
    taken = tuple(steps(system, left, solution))
    return Dae(system, q, qd, tau, counts, residuals, solution, qdd, wrenches, left, taken, comparison, tuple(warnings))


def independent_rows(rows: Floats, first: int = 0) -> NDArray[np.bool_]:
    """Return which unit rows (m, n) do not follow from those before them: they stop a motion that those allow; first:
    so many rows are independent, as those of joints and mimic rules of a tree are."""
    motions = null_space(rows[:first], DEPENDENT) if first else np.eye(rows.shape[1])
    independent = np.ones(len(rows), dtype=bool)
    for k in range(first, len(rows)):
        stopped = motions @ rows[k]
        independent[k] = length(stopped) > DEPENDENT
        if independent[k]:
            motions = null_space(stopped[None], 0.0) @ motions
    return independent


def counted(system: System, rows: Floats, independent: NDArray[np.bool_], left: Reduced) -> Counts:
    """Return the counts. With r independent rows of G and the mass matrix H of the motions that they leave, the
    coefficients (M, G^T) of accelerations and reactions have the rank r + rank H, and together with (G, 0) r more."""
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
    redundant = tuple(names[k] for k in np.flatnonzero(~independent))
    open_ones = tuple(names[k] for k in undetermined)
    sizes = (laws, laws, r + laws), rows.shape[1] + r
    return Counts(len(system.inertias), len(names), r, redundant, open_ones, *sizes)


def solved(found: Matrices, independent: NDArray[np.bool_]) -> Solution:
    """a and reactions of `M a - G^T reactions = f`, `G a = gamma`, redundant rows of G left out: they have none. What
    the first solution misses is solved for again: so small reactions are as good beside large ones."""
    G, n, m = found.G[independent], len(found.f), int(independent.sum())
    K, right = np.block([[found.M, G.T], [G, np.zeros((m, m))]]), np.concatenate((found.f, found.gamma[independent]))
    x = np.linalg.solve(K, right)
    x = x + np.linalg.solve(K, right - K @ x)
    reactions = np.zeros(len(found.G))
    reactions[independent] = -x[n:]
    return Solution(x[:n], reactions)


def accelerations_along(system: System, a: Floats) -> Floats:
    return np.array(system.own_rates(list(system.matrices.S @ a + system.matrices.sigma)))


def reduced(system: System) -> Reduced:
    """The elimination, without its check: J, Jdot qd, and the projections J^T M J and J^T (f - M drift)."""
    model, q, centres = system.model, system.sample.q, system.centres
    # column k has the velocities of all bodies where coordinate k alone moves, at 1 per second
    J = np.stack([velocities_of(state_of(model, centres, q, unit)) for unit in np.eye(model.n).tolist()], axis=1)
    parents, joints = model.parents, system.sample.motions()
    each = zip(poses(parents, joints), velocities(parents, joints), accelerations(parents, joints), strict=True)
    drift = narrowed(np.concatenate([
        part
        for (pose, (w, _), (wd, a)), r in zip(each, centres, strict=True)
        for part in (wd, pose.R @ acceleration_of_point(a, r, w, wd))
    ]))  # fmt: skip
    M, f, G, gamma, *_ = system.matrices
    loops = slice(system.tree, None)
    return Reduced(J, drift, J.T @ M @ J, J.T @ (f - M @ drift), G[loops] @ J, gamma[loops] - G[loops] @ drift)


def steps(system: System, left: Reduced, solution: Solution | None) -> Iterator[Step]:
    """Yield every step with its identity, held against numbers from elsewhere; without a solution those that need none.
    Errors are parts of the magnitudes that add up to what is compared."""
    M, f, G, gamma, *_ = system.matrices
    J, drift = left.J, left.drift
    held, asked = G[: system.tree], gamma[: system.tree]
    q, qd, tau = (np.array(x, dtype=float) for x in (system.sample.q, system.sample.qd, system.tau))
    tree = replace(system.scene, loops=())

    def step(title: str, formula: str, checks: str, one: Floats, other: Floats | float, sizes: Floats) -> Step:
        scale, difference = _largest(sizes), _largest(one - other)
        return Step(title, formula, checks, difference / scale if scale > VANISHING else difference, scale)

    forces = np.abs(J.T) @ (np.abs(f) + np.abs(M) @ np.abs(drift))
    what = "velocities of the bodies from those of the joints: they fulfil every joint's constraints by themselves"
    yield step(what, "v = J(q) qd", "G J = 0", held @ J, 0.0, np.abs(held) @ np.abs(J))
    sizes = np.abs(held) @ np.abs(drift) + np.abs(asked)
    yield step("accelerations likewise", "a = J qdd + Jdot qd", "G Jdot qd = gamma", held @ drift, asked, sizes)
    what = "inserted in M a = f + G^T lambda, and multiplied by J^T from the left: the reactions do no work and go"
    formula = "J^T M (J qdd + Jdot qd) = J^T f + J^T G^T lambda"
    yield step(what, formula, "J^T G^T = 0", J.T @ held.T, 0.0, np.abs(J.T) @ np.abs(held.T))
    what, checks = "the masses of the bodies become the mass matrix", "J^T M J against M(q) of the recursion"
    recursion = mass_matrix(system.model, q, scene=tree, executor="numpy")
    yield step(what, "J^T M J = M(q)", checks, left.M, recursion, np.abs(J.T) @ np.abs(M) @ np.abs(J))
    what, formula = "the forces become torques less the bias", "J^T (f - M Jdot qd) = tau - bias(q, qd)"
    bias = bias_forces(system.model, q, qd, scene=tree, executor="numpy")
    yield step(what, formula, "against bias(q, qd) of the recursion", left.free, tau - bias, forces)
    if solution is None:
        return
    qdd, carried = accelerations_along(system, solution.a), solution.reactions[system.tree :]
    what, formula, checks = "the ODE form", "M(q) qdd = tau - bias(q, qd)", "with qdd of the DAE"
    if system.loops:
        what, checks = "what is left: loops keep their reactions, with G_l = G J", "with qdd and lambda of the DAE"
        formula += " + G_l^T lambda_l,  G_l qdd = gamma_l"
    sizes = np.abs(left.M) @ np.abs(qdd) + np.abs(left.G.T) @ np.abs(carried) + forces
    yield step(what, formula, checks, left.M @ qdd, left.free + left.G.T @ carried, sizes)
    if system.loops:
        what = "the motions that the loops leave, G_l N = 0: their reactions go too"
        formula = "qdd = q_p + N z,  N^T M N z = N^T (tau - bias - M q_p)"
        sizes = np.abs(qdd) + np.abs(drift).max(initial=0.0)
        yield step(what, formula, "qdd of these against that of the DAE", left.accelerations(), qdd, sizes)
    again = J @ qdd + drift
    what, checks = "back to the reactions, where they are asked for", "with qdd of the ODE form and lambda of the DAE"
    sizes = np.abs(M) @ np.abs(again) + np.abs(f)
    yield step(what, "G^T lambda = M a - f", checks, G.T @ solution.reactions, M @ again - f, sizes)


def compared(system: System, solution: Solution, qdd: Floats, wrenches: Sequence[Wrench]) -> Comparison:
    """Return the solution of the saddle-point system beside what recursions make of the same state. qdd by articulated
    bodies, or with loops by `robodyn.dynamics.loops`; then the recursion of forces, in which what loops carry are
    loads."""
    model, scene, sample, (a, reactions) = system.model, system.scene, system.sample, solution
    if scene.loops:
        chain = closed_chain(plan(model, scene)).resisting()
        closed = replace(sample, model=chain.model)
        terms = applied(bias_plan(model, scene).effects, closed, scene)
        ode = np.array(chain.accelerations(closed, terms, list(system.tau))[0], dtype=float)
    else:
        q, qd, tau = (np.array(x, dtype=float) for x in (sample.q, sample.qd, system.tau))
        ode = forward_dynamics(model, q, qd, tau, scene=scene, executor="numpy")
    acting = (*system.terms.wrenches, *system.loop_wrenches(reactions))
    terms = replace(system.terms, qd=sample.qd, qdd=tuple(ode.tolist()), wrenches=acting)
    others = narrowed_all(loads(sample, terms).reactions)
    (f, n), (f_ode, n_ode) = (np.array(each, dtype=float).swapaxes(0, 1) for each in (wrenches, others))
    moved = [part.reshape(-1, 6)[:, 3:] for part in (system.matrices.f, system.matrices.M @ a)]
    force = max(_largest(part) for part in (*moved, f_ode))
    fastest = max(_largest(part) for part in (ode, a, scene.gravity))
    scales = fastest, force, max(_largest(n_ode), force * system.length)
    pairs = zip((qdd - ode, f - f_ode, n - n_ode), scales, strict=True)
    return Comparison(ode, *(_largest(difference) / (scale or 1.0) for difference, scale in pairs))


def _largest(values: ArrayLike) -> float:
    return float(np.abs(np.asarray(values, dtype=float)).max(initial=0.0))
