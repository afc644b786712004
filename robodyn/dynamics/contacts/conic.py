"""Contact forces by Clarabel, an interior-point solver with exact cones, one sample at a time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from robodyn.dynamics.contacts.problem import FEASIBLE, Forces, Problem, axes_of
from robodyn.programs.linear import shortest
from robodyn.programs.vectors import length, product
from robodyn.support.extras import need
from robodyn.support.floats import Floats

TOLERANCE = 1e-12
MISSING = 1e7
"""Where there is no solution, 1/2 this |b - G f|^2 is a part of the cost, relative to its largest curvature."""


@dataclass(frozen=True)
class _Sample:
    """One sample in units of |b|: min 1/2 x' P x + q' x, A x = b, x in cones, |tau0 - M x| <= limits.

    x are three components of the force at each active point, in axes of the contact, and the free unknowns.
    """

    P: Floats
    q: Floats
    A: Floats
    b: Floats
    friction: Floats
    tau0: Floats
    M: Floats
    limits: Floats


def conic_forces(problem: Problem) -> Forces:
    """Return what `contact_forces` returns, of any problem.

    Limits of torques give way before the equations do; where these have no solution in the cones, the squares of what
    is missing weigh 1e7 times as much as forces.
    """
    need("contact forces that cost torques or are bounded by them", "clarabel")
    N, R, K = problem.shape
    L = 0 if problem.free is None else problem.free.H.shape[2]
    f, free, residual = np.zeros((N, K, 3)), np.zeros((N, L)), np.zeros((N, R))
    within, feasible = np.ones(N, dtype=bool), np.ones(N, dtype=bool)
    axes = np.broadcast_to(axes_of(problem.normals), (N, K, 3, 3))
    for n in range(N):
        active = np.ones(K, dtype=bool) if problem.active is None else problem.active[n]
        size = length(problem.b[n]) or 1.0
        sample = _sample(problem, n, active, axes[n], size)
        x, within[n] = _solved(sample)
        points = int(active.sum())
        f[n, active] = size * np.einsum("kij,kj->ki", axes[n][active], x[: 3 * points].reshape(points, 3))
        free[n] = size * x[3 * points :]
        residual[n] = problem.b[n] - product(problem.G[n], f[n].ravel())
        if problem.free is not None:
            residual[n] -= product(problem.free.H[n], free[n])
        feasible[n] = length(residual[n]) <= FEASIBLE * size
    return Forces(f, free, residual, feasible, within)


def _sample(problem: Problem, n: int, active: Any, axes: Floats, size: float) -> _Sample:
    used = np.repeat(active, 3)
    turn = np.zeros((len(used), len(used)))
    for k in range(len(active)):
        turn[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = axes[k]
    turn = turn[:, used]
    A, b = product(problem.G[n], turn), problem.b[n] / size
    weights = np.ones(len(active)) if problem.weights is None else problem.weights
    diagonal = np.repeat(weights[active], 3)
    M, tau0, limits = np.zeros((0, A.shape[1])), np.zeros(0), np.zeros(0)
    terms, free = problem.torques, problem.free
    if terms is not None:
        M, tau0 = product(terms.T[n], turn), terms.tau0[n] / size
        limits = np.full(len(tau0), np.inf) if terms.limits is None else terms.limits / size
    if free is not None:
        L = free.H.shape[2]
        A = np.hstack((A, free.H[n]))
        M = np.hstack((M, free.S[n] if free.S is not None else np.zeros((len(M), L))))
        diagonal = np.append(diagonal, np.full(L, free.weight))
    w = np.zeros(0) if terms is None else terms.weights
    P = np.diag(diagonal) + product(M.T * w, M)
    friction = np.broadcast_to(problem.friction, (problem.shape[0], len(active)))[n][active]
    return _Sample(P, -product(M.T * w, tau0), A, b, friction, tau0, M, limits)


def _solved(sample: _Sample) -> tuple[Floats, bool]:
    """Return x, and whether the torques stay within their limits."""
    bounded = bool(np.isfinite(sample.limits).any())
    for limited in (True, False) if bounded else (False,):
        x = _by_clarabel(sample, limited, soft=False)
        if x is not None:
            return x + shortest(sample.A, sample.b - product(sample.A, x), 1e-10), limited or not bounded
    x = _by_clarabel(sample, limited=False, soft=True)
    if x is None:
        raise ArithmeticError("Clarabel finds no least residual")
    excess = np.abs(sample.tau0 - product(sample.M, x)) <= sample.limits * (1.0 + 1e-9)
    return x, bool(excess.all())


def _by_clarabel(sample: _Sample, limited: bool, soft: bool) -> Floats | None:
    """Return x; None where there is none. Soft equations are a part of the cost."""
    import clarabel
    from scipy import sparse

    P, q, rows, bounds, cones = sample.P, sample.q, [], [], []
    if soft:
        weight = MISSING * float(np.abs(P).max(initial=1e-300))
        P = P + weight * product(sample.A.T, sample.A)
        q = q - weight * product(sample.A.T, sample.b)
    else:
        rows, bounds, cones = [sample.A], [sample.b], [clarabel.ZeroConeT(len(sample.b))]
    if limited:
        finite = np.isfinite(sample.limits)
        M, tau0, limits = sample.M[finite], sample.tau0[finite], sample.limits[finite]
        rows += [-M, M]
        bounds += [limits - tau0, limits + tau0]
        cones += [clarabel.NonnegativeConeT(2 * len(limits))]
    for k, mu in enumerate(sample.friction.tolist()):
        block = np.zeros((3, len(q)))
        block[[1, 2, 0], range(3 * k, 3 * k + 3)] = -1.0, -1.0, -mu
        if np.isinf(mu):
            block = block[:1]
            block[0, 3 * k + 2] = -1.0
        rows.append(block)
        bounds.append(np.zeros(len(block)))
        cones.append(clarabel.NonnegativeConeT(1) if np.isinf(mu) else clarabel.SecondOrderConeT(3))
        if mu == 0.0:
            normal = np.zeros((1, len(q)))
            normal[0, 3 * k + 2] = -1.0
            rows.append(normal)
            bounds.append(np.zeros(1))
            cones.append(clarabel.NonnegativeConeT(1))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix(np.triu(P)),
        q,
        sparse.csc_matrix(np.vstack(rows)),
        np.concatenate(bounds),
        cones,
        settings,
    )
    solution = solver.solve()
    if solution.status in (clarabel.SolverStatus.Solved, clarabel.SolverStatus.AlmostSolved):
        return np.array(solution.x)
    return None
