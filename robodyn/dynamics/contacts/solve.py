"""Contact forces of blocks of samples: what is asked and found, and why there are none."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.contacts.dual import FEASIBLE, SOFTNESS, Cones, least_forces
from robodyn.errors import InputError
from robodyn.programs.vectors import length, product
from robodyn.support.extras import need
from robodyn.support.floats import BEYOND, Floats, einsum
from robodyn.support.linear import min_norm_solution

Flags = NDArray[np.bool_]
TOLERANCES = (1e-12, 1e-10, 1e-8, 1e-6)
"""Tried in turn, for Clarabel gets stuck with small ones at times."""
SCALES = "look for masses, inertias or efforts of unlikely sizes"
FREE = 1e-9
"""Cost of the square of a free unknown, beside 1 of a force's."""
MISSING = 1.0 / SOFTNESS[-1]
"""Where there is no solution, 1/2 this |b - G f|^2 is a part of the cost, relative to its largest curvature."""
FORCES = slice(3, 6)
"""Rows of the equations, of which the first six are moments and forces on the base."""
STRONGEST = 100.0
"""Times |b|: what needs larger forces, as feet that are all but wedged do, counts as impossible."""
MANY = 100_000
"""Samples that a search is worth, by which its executor is chosen: it looks at few of them often."""
WORST, SECTIONS = 8, 15
"""Samples whose least friction is sought at a time, and how many coefficients are tried between two bounds."""
FLAT = 1e-9
"""Of the largest distance between points: what stands out less from a line lies on it. Of the force that presses: less
along the ground is none."""


@dataclass(frozen=True)
class TorqueTerms:
    """Torques tau = tau0 - T f - S x of m joints, T being (N, m, 3 K): their cost 1/2 sum w tau^2, and limits (m,)."""

    tau0: Floats
    T: Floats
    weights: Floats
    limits: Floats | None = None


@dataclass(frozen=True)
class FreeTerms:
    """Unknowns x without a sign, such as the forces of loops: G f + H x = b, H being (N, R, L). They take S x from the
    torques, S being (N, m, L), or None: nothing."""

    H: Floats
    S: Floats | None = None


@dataclass(frozen=True)
class Problem:
    """Forces f_k at K points, of N samples: G f = b, |f_t| <= mu f_n, f_n >= 0, at the least 1/2 sum |f_k|^2 and cost
    of torques. Where no such forces are, |b - G f| is least first.

    Attributes:
        G: (N, R, 3 K), by components of f_1, f_2, ...; b: (N, R). A residual of one row weighs as much as of any other.
        normals: (K, 3) or (N, K, 3), of length 1, to the side on which the robot is.
        friction: (K,) or (N, K), mu; may be 0 or infinite.
        active: (N, K); None: all. Where it is False f is 0.
    """

    G: Floats
    b: Floats
    normals: Floats
    friction: Floats
    active: Flags | None = None
    torques: TorqueTerms | None = None
    free: FreeTerms | None = None

    @property
    def shape(self) -> tuple[int, int, int]:
        """N, R and K."""
        samples, rows, columns = self.G.shape
        return samples, rows, columns // 3

    def chosen(self, rows: Any) -> Problem:
        names = ("G", "b", "active", *["normals"] * (self.normals.ndim == 3), *["friction"] * (self.friction.ndim == 2))
        torques, free = _rows(self.torques, rows, ("tau0", "T")), _rows(self.free, rows, ("H", "S"))
        own: Problem = _rows(self, rows, names)
        return replace(own, torques=torques, free=free)


def _rows(of: Any, rows: Any, names: Iterable[str]) -> Any:
    """Return the same with some rows of these arrays, so far as they are there."""
    return of and replace(of, **{name: array[rows] for name in names if (array := getattr(of, name)) is not None})


@dataclass(frozen=True)
class Forces:
    """What was found.

    Attributes:
        f: (N, K, 3), on the robot, in the axes of the normals; free: (N, L), the unknowns x.
        residual: (N, R), b - G f - H x; feasible: (N,), whether it is at most FEASIBLE |b|.
        within_limits: (N,), False where torques had to exceed their limits.
    """

    f: Floats
    free: Floats
    residual: Floats
    feasible: Flags
    within_limits: Flags

    def chosen(self, rows: Any) -> Forces:
        own: Forces = _rows(self, rows, [each.name for each in fields(self)])
        return own


def axes_of(normals: Floats) -> Floats:
    """Rotations (..., 3, 3) whose columns are two tangents and the normal (..., 3) (Duff and others 2017)."""
    x, y, z = np.moveaxis(normals, -1, 0)
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    first = np.stack((1.0 + sign * x * x * a, sign * b, -sign * x), -1)
    second = np.stack((b, sign + y * y * a, -y), -1)
    return np.stack((first, second, normals), -1)


def scaled(problem: Problem) -> tuple[Cones, Floats]:
    """Return the problem with |b| = 1, in which forces of inactive points do nothing; and |b| (N,)."""
    N, sizes = len(problem.b), np.sqrt(einsum("ni,ni->n", problem.b, problem.b))
    G = problem.G if problem.active is None else problem.G * np.repeat(problem.active, 3, axis=1)[:, None]
    angle = np.arctan(problem.friction)
    cosine = np.where(np.isinf(problem.friction), 0.0, np.cos(angle))
    parts = (problem.normals.reshape(*problem.normals.shape[:-2], -1), cosine, np.sin(angle))
    normals, cosine, sine = (np.broadcast_to(part, (N, part.shape[-1])).T for part in parts)
    return Cones(G.reshape(N, -1).T, problem.b.T / np.where(sizes > 0.0, sizes, 1.0), normals, cosine, sine), sizes


@dataclass(frozen=True)
class _Sample:
    """One sample in units of |b|: min 1/2 x' P x + q' x, A x = b, x in cones, |tau0 - M x| <= limits. x are the force
    at each active point, in axes of the contact, and the free unknowns."""

    P: Floats
    q: Floats
    A: Floats
    b: Floats
    friction: Floats
    tau0: Floats
    M: Floats
    limits: Floats


def conic_forces(problem: Problem) -> Forces:
    """Return what `contact_forces` returns, of any problem. Limits of torques give way before the equations do; where
    these have no solution in the cones, the squares of what is missing weigh 1e6 times as much as forces."""
    need("contact forces that cost torques or are bounded by them", "clarabel")
    N, R, K = problem.shape
    terms, unknown = problem.torques, problem.free
    L = 0 if unknown is None else unknown.H.shape[2]
    f, free, residual = np.zeros((N, K, 3)), np.zeros((N, L)), np.zeros((N, R))
    within, feasible = np.ones(N, dtype=bool), np.ones(N, dtype=bool)
    axes = np.broadcast_to(axes_of(problem.normals), (N, K, 3, 3))
    frictions = np.broadcast_to(problem.friction, (N, K))
    for n in range(N):
        active = np.ones(K, dtype=bool) if problem.active is None else problem.active[n]
        size = length(problem.b[n]) or 1.0
        turn = np.zeros((K, 3, K, 3))
        turn[np.arange(K), :, np.arange(K)] = axes[n]
        turn = turn.reshape(3 * K, 3 * K)[:, np.repeat(active, 3)]
        A, diagonal = product(problem.G[n], turn), np.ones(turn.shape[1])
        M, tau0, limits, w = np.zeros((0, A.shape[1])), np.zeros(0), np.zeros(0), np.zeros(0)
        if terms is not None:
            M, tau0, w = product(terms.T[n], turn), terms.tau0[n] / size, terms.weights
            limits = np.full(len(tau0), np.inf) if terms.limits is None else terms.limits / size
        if unknown is not None:
            A, diagonal = np.hstack((A, unknown.H[n])), np.append(diagonal, np.full(L, FREE))
            M = np.hstack((M, np.zeros((len(M), L)) if terms is None or unknown.S is None else unknown.S[n]))
        P, q = np.diag(diagonal) + product(M.T * w, M), -product(M.T * w, tau0)
        x, within[n] = _solved(_Sample(P, q, A, problem.b[n] / size, frictions[n][active], tau0, M, limits))
        if x is None:
            raise InputError("no contact forces are found, not even such as leave the least unbalanced", remedy=SCALES)
        points = int(active.sum())
        f[n, active] = size * einsum("kij,kj->ki", axes[n][active], x[: 3 * points].reshape(points, 3))
        free[n] = size * x[3 * points :]
        residual[n] = problem.b[n] - product(problem.G[n], f[n].ravel())
        if unknown is not None:
            residual[n] -= product(unknown.H[n], free[n])
        feasible[n] = length(residual[n]) <= FEASIBLE * size
    return Forces(f, free, residual, feasible, within)


def _solved(sample: _Sample) -> tuple[Floats | None, bool]:
    """Return x, None where it is not found, and whether the torques stay within their limits."""
    bounded = bool(np.isfinite(sample.limits).any())
    for limited in (True, False) if bounded else (False,):
        x = _by_clarabel(sample, limited)
        if x is not None:
            return x + min_norm_solution(sample.A, sample.b - product(sample.A, x), 1e-10), limited or not bounded
    # r is added to the equations, A x + r / sqrt(MISSING) = b, and costs as forces do
    R, n = sample.A.shape
    P = np.zeros((n + R, n + R))
    P[:n, :n], P[n:, n:] = sample.P, np.eye(R) * (float(np.abs(sample.P).max(initial=0.0)) or 1.0)
    A, M = np.hstack((sample.A, np.eye(R) / np.sqrt(MISSING))), np.hstack((sample.M, np.zeros((len(sample.M), R))))
    x = _by_clarabel(replace(sample, P=P, q=np.append(sample.q, np.zeros(R)), A=A, M=M), limited=False)
    if x is None:
        return None, False
    within = np.abs(sample.tau0 - product(sample.M, x[:n])) <= sample.limits * BEYOND
    return x[:n], bool(within.all())


def _by_clarabel(sample: _Sample, limited: bool) -> Floats | None:
    import clarabel
    from scipy import sparse

    parts = [(clarabel.ZeroConeT(len(sample.b)), sample.A, sample.b)]
    if limited:
        finite = np.isfinite(sample.limits)
        M, tau0, limits = sample.M[finite], sample.tau0[finite], sample.limits[finite]
        bounds = np.append(limits - tau0, limits + tau0)
        parts.append((clarabel.NonnegativeConeT(len(bounds)), np.vstack((-M, M)), bounds))
    for k, mu in enumerate(sample.friction.tolist()):
        block = np.zeros((4, len(sample.q)))
        block[[0, 2, 3], [3 * k + 2, 3 * k, 3 * k + 1]] = -1.0
        parts.append((clarabel.NonnegativeConeT(1), block[:1], np.zeros(1)))
        if np.isfinite(mu):
            block[1, 3 * k + 2] = -mu
            first, cone = (1, clarabel.SecondOrderConeT(3)) if mu > 0.0 else (2, clarabel.ZeroConeT(2))
            parts.append((cone, block[first:], np.zeros(4 - first)))
    scale = float(np.abs(sample.P).max(initial=0.0)) or 1.0
    cones, rows, bounds_of_all = zip(*parts, strict=True)
    P, A = sparse.csc_matrix(np.triu(sample.P) / scale), sparse.csc_matrix(np.vstack(rows))
    b = np.concatenate(bounds_of_all)
    for tolerance in TOLERANCES:
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
        solution = clarabel.DefaultSolver(P, sample.q / scale, A, b, list(cones), settings).solve()
        if solution.status == clarabel.SolverStatus.Solved:
            return np.array(solution.x)
        if solution.status in (clarabel.SolverStatus.PrimalInfeasible, clarabel.SolverStatus.AlmostPrimalInfeasible):
            return None
    return None


def contact_forces(problem: Problem, executor: str = "auto", expected: int = 0) -> Forces:
    """Return the forces of least cost that the equations, the cones and the limits allow.

    Where forces alone are unknown and cost, Newton's method on the dual finds those of all samples at a time; else
    Clarabel does, one sample after another (InputError where it is not installed). Forces of hundreds of times |b|, as
    between wedges, may not be found.

    Args:
        executor: of the programs: "auto", "numpy" or "compiled"; where one is named, results do not depend on the
            block.
        expected: samples of the whole work that these are a part of; 0: these are all.

    Accuracy: without costs of torques and free unknowns, the residual is at most 1e-12 of |b| or |f| where forces
        exist, and their cost is the least to 1e-8 |b|^2; else what Clarabel reaches, 1e-9 |b|.
    """
    if problem.torques is not None or problem.free is not None:
        return conic_forces(problem)
    cones, sizes = scaled(problem)
    N, _, K = problem.shape
    f, _ = least_forces(cones, executor, expected)
    found = (f.reshape(K, 3, N) * sizes).transpose(2, 0, 1)
    if problem.active is not None:
        found = np.where(problem.active[:, :, None], found, 0.0)
    residual = problem.b - einsum("nij,nj->ni", problem.G, found.reshape(N, 3 * K))
    missing = np.sqrt(einsum("ni,ni->n", residual, residual))
    return Forces(found, np.zeros((N, 0)), residual, missing <= FEASIBLE * sizes, np.ones(N, dtype=bool))


def kinds(problem: Problem, forces: Forces, executor: str = "auto") -> list[str]:
    """Return why each sample has no forces: "" (it has), "slip", "pull" or "tip".

    slip: unlimited friction would suffice. pull: even without the equations of moments, unlimited friction would not,
    so that contacts had to pull. tip: all else. The problem's first six equations are moments and forces on the base.
    """
    found = np.full(len(forces.feasible), "", dtype=object)
    lost = np.flatnonzero(~forces.feasible)
    if len(lost):
        unlimited = _with_friction(problem.chosen(lost), np.inf)
        slip = contact_forces(unlimited, executor).feasible
        found[lost] = np.where(slip, "slip", "tip")
        if not slip.all():
            rest = unlimited.chosen(~slip)
            alone = replace(rest, G=rest.G[:, FORCES], b=rest.b[:, FORCES], free=None)
            found[lost[~slip][~contact_forces(alone, executor).feasible]] = "pull"
    return [str(kind) for kind in found]


def least_friction(problem: Problem, known: float = 0.0, executor: str = "auto") -> float | None:
    """Return the least mu of all contacts alike, not below `known`, with which every sample has forces; None if none
    has.

    Forces of more than 100 |b| do not count: where contacts wedge between each other, less friction would do, with
    forces beyond all bounds. What torques cost and their limits do not count either. The samples that miss most are
    solved for their own least mu, with many mu at a time; then those that still miss something, until none does.

    Accuracy: 1e-6 relative; 1e-5 where forces become singular at the least mu.
    """
    mu, left = known, np.arange(len(problem.b))
    while True:
        part = problem.chosen(left)
        found = contact_forces(_with_friction(part, mu), executor, MANY)
        lost = ~_moderate(part, found)
        left = left[lost]
        if not len(left):
            return mu
        lacking = found.residual[lost]
        worst = problem.chosen(left[np.argsort(-einsum("ni,ni->n", lacking, lacking), kind="stable")[:WORST]])
        ladder: Floats = max(0.25, 2.0 * mu) * 4.0 ** np.arange(SECTIONS, dtype=float)
        held = _suffices(worst, ladder, executor)
        if not held.any():
            return None
        first = int(held.argmax())
        low, mu = max(mu, float(ladder[first - 1]) if first else mu), float(ladder[first])
        while mu - low > 1e-6 * mu:
            between = np.linspace(low, mu, SECTIONS + 2)
            first = int(np.append(_suffices(worst, between[1:-1], executor), True).argmax())
            low, mu = float(between[first]), float(between[first + 1])


def _suffices(problem: Problem, friction: Floats, executor: str) -> Flags:
    """Return (M,) with which of M mu all samples have forces."""
    M, (N, _, K) = len(friction), problem.shape
    mu = np.repeat(friction, N)[:, None] * np.ones(K)
    every = replace(problem.chosen(np.tile(np.arange(N), M)), friction=mu, torques=None)
    enough = _moderate(every, contact_forces(every, executor, MANY)).reshape(M, N)
    return np.asarray(enough.all(axis=1))


def _moderate(problem: Problem, found: Forces) -> Flags:
    """(N,) which samples have forces, of no more than 100 |b|."""
    strength, b = (np.sqrt(einsum("...i,...i->...", x, x)) for x in (found.f.reshape(len(found.f), -1), problem.b))
    return np.asarray(found.feasible & (strength <= STRONGEST * b))


def _with_friction(problem: Problem, mu: float) -> Problem:
    return replace(problem, friction=np.full(problem.shape[2], mu), torques=None)


def centre_of_pressure(points: Floats, normal: Floats, forces: Floats) -> tuple[Floats, Floats]:
    """Return where the total force of a contact meets the plane of its points (N, 3) m, which is across the normal
    through their mean; and how far that is (N,) m from the nearest line through an edge of their convex hull, negative
    beyond one.

    They are not numbers where the contact does not press, nor is the distance where there are fewer than three points.

    Args:
        points, forces: (N, K, 3) m and N, in any axes; normal: (N, 3) or (3,), of length 1.
    """
    N, K, _ = points.shape
    normal = np.broadcast_to(normal, (N, 3))
    middle = points.mean(axis=1)
    arms, force = points - middle[:, None], forces.sum(axis=1)
    moment = np.cross(arms, forces).sum(axis=1)
    press = einsum("ni,ni->n", force, normal)
    with np.errstate(all="ignore"):
        place = np.cross(normal, moment) / np.where(press > 0.0, press, np.nan)[:, None]
    if K < 3:
        return middle + place, np.full(N, np.nan)
    tangents = axes_of(normal)[:, :, :2]
    corners, at = einsum("nki,nij->nkj", arms, tangents), einsum("ni,nij->nj", place, tangents)
    along = corners[:, None, :, :] - corners[:, :, None, :]
    lengths = np.sqrt((along * along).sum(axis=-1))
    size = lengths.max(axis=(1, 2), keepdims=True)
    with np.errstate(all="ignore"):  # an edge of the hull is a pair of corners that has all others to its left
        inward = np.stack((-along[..., 1], along[..., 0]), -1) / lengths[..., None]
        left = einsum("nabi,nabki->nabk", inward, corners[:, None, None] - corners[:, :, None, None])
        edge = (left >= -FLAT * size[..., None]).all(axis=-1) & (lengths > FLAT * size)
        distance = einsum("nabi,nabi->nab", inward, at[:, None, None] - corners[:, :, None])
    margin = np.where(edge, distance, np.inf).min(axis=(1, 2))
    return middle + place, np.where(np.isnan(at[:, 0]), np.nan, margin)


def friction_used(forces: Floats, normal: Floats, friction: float) -> Floats:
    """Return sum |f_t| / (mu sum f_n) over the points of a contact, 1 being all that there is; forces: (..., K, 3).
    Where nothing presses it is not a number; where mu is 0 it is 0 or infinite."""
    press = einsum("...i,i->...", forces, normal)
    across = forces - press[..., None] * normal
    along = np.sqrt(einsum("...i,...i->...", across, across)).sum(axis=-1)
    press = press.sum(axis=-1)
    with np.errstate(all="ignore"):
        return np.where(press > 0.0, np.where(along > FLAT * press, along / (friction * press), 0.0), np.nan)
