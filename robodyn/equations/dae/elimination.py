"""From the DAE to the ODE form: the reactions are eliminated by a transformation of velocities, step by step."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.forward import forward_dynamics
from robodyn.dynamics.inverse import bias_forces
from robodyn.dynamics.loops.closed_chain import closed_chain
from robodyn.dynamics.mass import mass_matrix
from robodyn.dynamics.plan import applied, loads, plan
from robodyn.equations.dae.constraints import accelerations_of, state_of
from robodyn.equations.dae.system import System
from robodyn.equations.ode import bias_plan
from robodyn.programs.linear import min_norm_solution, null_space
from robodyn.programs.vectors import narrowed, narrowed_all
from robodyn.robot.kinematics import Wrench
from robodyn.support.floats import Floats

LOOSE = 1e-10
"""Equations of loops of which no more than this part of the largest is left follow from the others."""
VANISHING = 1e-25
"""What rounding leaves of magnitudes that are all zero: nothing is measured by them."""


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


def reduced(system: System) -> Reduced:
    """J from the motion of the joints, one at a time, and the projections J^T M J and J^T (f - M drift)."""
    J, drift = velocity_transformation(system), accelerations_at_rest(system)
    M, f, G, gamma, *_ = system.matrices
    loops = slice(system.tree, None)
    return Reduced(J, drift, J.T @ M @ J, J.T @ (f - M @ drift), G[loops] @ J, gamma[loops] - G[loops] @ drift)


def velocity_transformation(system: System) -> Floats:
    """J(q): column k has the velocities of all bodies where coordinate k alone moves, at 1 per second."""
    model, q = system.model, system.sample.q
    return np.stack([state_of(model, system.centres, q, unit).v for unit in np.eye(model.n).tolist()], axis=1)


def accelerations_at_rest(system: System) -> Floats:
    """Jdot qd: the accelerations of all bodies where no coordinate accelerates."""
    model, sample = system.model, system.sample
    each = accelerations_of(model, system.centres, sample.q, sample.qd, (0.0,) * model.n)
    return narrowed(np.concatenate([part for pair in each for part in pair]))


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


def _step(title: str, formula: str, checks: str, one: Floats, other: Floats | float, sizes: Floats) -> Step:
    """Return a step, of what it says to be equal, and magnitudes that add up to it."""
    scale = float(np.max(sizes, initial=0.0))
    difference = float(np.max(np.abs(one - other), initial=0.0))
    return Step(title, formula, checks, difference / scale if scale > VANISHING else difference, scale)


def steps(system: System, left: Reduced, a: Floats | None, reactions: Floats) -> Iterator[Step]:
    """Yield every step with its identity, held against numbers from elsewhere; without `a` those that need none."""
    M, f, G, gamma, *_ = system.matrices
    J, drift = left.J, left.drift
    held, asked = G[: system.tree], gamma[: system.tree]
    q, qd, tau = (np.array(x, dtype=float) for x in (system.sample.q, system.sample.qd, system.tau))
    tree = replace(system.scene, loops=())
    forces = np.abs(J.T) @ (np.abs(f) + np.abs(M) @ np.abs(drift))
    what = "velocities of the bodies from those of the joints: they fulfil every joint's constraints by themselves"
    yield _step(what, "v = J(q) qd", "G J = 0", held @ J, 0.0, np.abs(held) @ np.abs(J))
    sizes = np.abs(held) @ np.abs(drift) + np.abs(asked)
    yield _step("accelerations likewise", "a = J qdd + Jdot qd", "G Jdot qd = gamma", held @ drift, asked, sizes)
    what = "inserted in M a = f + G^T lambda, and multiplied by J^T from the left: the reactions do no work and go"
    formula = "J^T M (J qdd + Jdot qd) = J^T f + J^T G^T lambda"
    yield _step(what, formula, "J^T G^T = 0", J.T @ held.T, 0.0, np.abs(J.T) @ np.abs(held.T))
    what, checks = "the masses of the bodies become the mass matrix", "J^T M J against M(q) of the recursion"
    recursion = mass_matrix(system.model, q, scene=tree, executor="numpy")
    yield _step(what, "J^T M J = M(q)", checks, left.M, recursion, np.abs(J.T) @ np.abs(M) @ np.abs(J))
    what, formula = "the forces become torques less the bias", "J^T (f - M Jdot qd) = tau - bias(q, qd)"
    bias = bias_forces(system.model, q, qd, scene=tree, executor="numpy")
    yield _step(what, formula, "against bias(q, qd) of the recursion", left.free, tau - bias, forces)
    if a is None:
        return
    qdd, carried = accelerations_along(system, a), reactions[system.tree :]
    what, formula, checks = "the ODE form", "M(q) qdd = tau - bias(q, qd)", "with qdd of the DAE"
    if system.loops:
        what, checks = "what is left: loops keep their reactions, with G_l = G J", "with qdd and lambda of the DAE"
        formula += " + G_l^T lambda_l,  G_l qdd = gamma_l"
    sizes = np.abs(left.M) @ np.abs(qdd) + np.abs(left.G.T) @ np.abs(carried) + forces
    yield _step(what, formula, checks, left.M @ qdd, left.free + left.G.T @ carried, sizes)
    if system.loops:
        what = "the motions that the loops leave, G_l N = 0: their reactions go too"
        formula, checks = (
            "qdd = q_p + N z,  N^T M N z = N^T (tau - bias - M q_p)",
            "qdd of these against that of the DAE",
        )
        sizes = np.abs(qdd) + np.abs(drift).max(initial=0.0)
        yield _step(what, formula, checks, left.accelerations(), qdd, sizes)
    again = J @ qdd + drift
    what, checks = "back to the reactions, where they are asked for", "with qdd of the ODE form and lambda of the DAE"
    sizes = np.abs(M) @ np.abs(again) + np.abs(f)
    yield _step(what, "G^T lambda = M a - f", checks, G.T @ reactions, M @ again - f, sizes)


def accelerations_along(system: System, a: Floats) -> Floats:
    """qdd out of the accelerations of the bodies."""
    return np.array(system.own_rates(list(system.matrices.S @ a + system.matrices.sigma)))


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


def compared(system: System, a: Floats, reactions: Floats, qdd: Floats, wrenches: Sequence[Wrench]) -> Comparison:
    """Return the solution of the saddle-point system beside what recursions make of the same state.

    qdd by articulated bodies, or with loops by `robodyn.dynamics.loops`; then the recursion of forces, in which what
    loops carry are loads.
    """
    model, scene, sample = system.model, system.scene, system.sample
    if scene.loops:
        chain = closed_chain(plan(model, scene)).resisting()
        closed = replace(sample, model=chain.model)
        found, _ = chain.accelerations(
            closed, applied(bias_plan(model, scene).effects, closed, scene), list(system.tau)
        )
        ode = np.array(found, dtype=float)
    else:
        q, qd, tau = (np.array(x, dtype=float) for x in (sample.q, sample.qd, system.tau))
        ode = forward_dynamics(model, q, qd, tau, scene=scene, executor="numpy")
    acting = (*system.terms.wrenches, *system.loop_wrenches(reactions))
    terms = replace(system.terms, qd=sample.qd, qdd=tuple(ode.tolist()), wrenches=acting)
    others = tuple(narrowed_all(loads(sample, terms).reactions))
    moved = [part.reshape(-1, 6)[:, 3:] for part in (system.matrices.f, system.matrices.M @ a)]
    force = max(_largest(part) for part in (*moved, [wrench.f for wrench in others]))
    moment = max(_largest([wrench.n for wrench in others]), force * system.length)
    return Comparison(
        ode,
        others,
        _difference(qdd, ode, max(_largest(part) for part in (ode, a, scene.gravity))),
        _difference([wrench.f for wrench in wrenches], [wrench.f for wrench in others], force),
        _difference([wrench.n for wrench in wrenches], [wrench.n for wrench in others], moment),
    )


def _largest(values: ArrayLike) -> float:
    return float(np.abs(np.asarray(values, dtype=float)).max(initial=0.0))


def _difference(one: ArrayLike, other: ArrayLike, scale: float) -> float:
    return _largest(np.asarray(one, dtype=float) - np.asarray(other, dtype=float)) / (scale or 1.0)
