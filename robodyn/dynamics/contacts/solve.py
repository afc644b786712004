"""Contact forces of blocks of samples, by the solver that suits what they cost and what bounds them."""

from __future__ import annotations

import numpy as np

from robodyn.dynamics.contacts.dual import Cones, least_forces
from robodyn.dynamics.contacts.problem import FEASIBLE, Forces, Problem, axes_of
from robodyn.support.floats import Floats


def contact_forces(problem: Problem, executor: str = "auto", expected: int = 0) -> Forces:
    """Return the forces of least cost that the equations, the cones and the limits allow.

    Where forces alone are unknown and cost, Newton's method on the dual finds those of all samples at a time; what else
    there is goes to Clarabel, one sample after another. Each sample is solved by itself, so results do not depend on
    its neighbours where an executor is named.

    Args:
        problem: of N samples.
        executor: of the programs: "auto", "numpy" or "compiled".
        expected: samples of the whole work that these are a part of; 0: these are all.

    Raises:
        InputError: Clarabel is needed and not installed.

    Accuracy: without costs of torques and free unknowns, the residual is at most 1e-12 |b| where forces exist, and
        their cost is the least to 1e-8 |b|^2; else what Clarabel reaches, 1e-9 |b|.
    """
    if not problem.plain:
        from robodyn.dynamics.contacts.conic import conic_forces

        return conic_forces(problem)
    cones, axes, sizes = local(problem)
    N, _, K = problem.shape
    f, _ = least_forces(cones, executor, expected)
    return in_given_axes(problem, f.T.reshape(N, K, 3), axes, sizes)


def local(problem: Problem) -> tuple[Cones, Floats, Floats]:
    """Return the problem in axes of the contacts with |b| = 1 and weights 1; those axes, and the lengths of f = 1."""
    N, R, K = problem.shape
    axes = np.broadcast_to(axes_of(problem.normals), (N, K, 3, 3))
    sizes = np.sqrt(np.einsum("ni,ni->n", problem.b, problem.b))
    scale = np.ones((N, K)) if problem.active is None else problem.active.astype(float)
    if problem.weights is not None:
        scale = scale * np.sqrt(problem.weights.max() / problem.weights)
    G = np.einsum("nikj,nkjl,nk->nikl", problem.G.reshape(N, R, K, 3), axes, scale)
    friction = np.broadcast_to(problem.friction, (N, K))
    cosine = np.where(np.isinf(friction), 0.0, np.cos(np.arctan(friction)))
    sine = np.sin(np.arctan(friction))
    b = problem.b / np.where(sizes > 0.0, sizes, 1.0)[:, None]
    parts = (np.ascontiguousarray(part.reshape(N, -1).T) for part in (G, b, cosine, sine))
    return Cones(*parts), axes, sizes[:, None] * scale


def in_given_axes(problem: Problem, f: Floats, axes: Floats, scale: Floats) -> Forces:
    """Return forces of the problem of `local` as those of the given one."""
    N, _, K = problem.shape
    found = np.einsum("nkij,nkj,nk->nki", axes, f, scale)
    residual = problem.b - np.einsum("nij,nj->ni", problem.G, found.reshape(N, 3 * K))
    missing, sizes = (np.sqrt(np.einsum("ni,ni->n", x, x)) for x in (residual, problem.b))
    return Forces(found, np.zeros((N, 0)), residual, missing <= FEASIBLE * sizes, np.ones(N, dtype=bool))
