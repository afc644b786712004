"""Contact forces of blocks of samples, by the solver that suits what they cost and what bounds them."""

from __future__ import annotations

import numpy as np

from robodyn.dynamics.contacts.dual import Cones, columns, least_forces
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

    Accuracy: of a sample with forces the residual is at most 1e-10 |b|, 1e-12 |b| but near the end of what friction
        allows; f agrees with Clarabel's within 1e-8 of the largest.
    """
    if not problem.plain:
        from robodyn.dynamics.contacts.conic import conic_forces

        return conic_forces(problem)
    cones, axes, sizes = local(problem)
    f = least_forces(cones, executor=executor, expected=expected)
    return in_given_axes(problem, f, axes, sizes)


def local(problem: Problem) -> tuple[Cones, Floats, Floats]:
    """Return the problem in axes of the contacts with |b| = 1 and all weights 1; those axes, and what b was."""
    N, R, K = problem.shape
    axes = np.broadcast_to(axes_of(np.asarray(problem.normals, dtype=float)), (N, K, 3, 3))
    sizes = np.sqrt(np.einsum("ni,ni->n", problem.b, problem.b))
    scale = np.ones((N, K)) if problem.active is None else problem.active.astype(float)
    if problem.weights is not None:
        scale = scale / np.sqrt(problem.weights)
    G = np.einsum("nikj,nkjl,nk->nikl", problem.G.reshape(N, R, K, 3), axes, scale).reshape(N, R, 3 * K)
    angle = np.broadcast_to(np.arctan(problem.friction), (N, K))
    b = problem.b / np.where(sizes > 0.0, sizes, 1.0)[:, None]
    cosine = np.where(np.isinf(problem.friction), 0.0, np.cos(angle))
    return Cones(columns(G), columns(b), columns(cosine), columns(np.sin(angle))), axes, sizes


def in_given_axes(problem: Problem, f: Floats, axes: Floats, sizes: Floats) -> Forces:
    """Return forces of the problem of `local` as those of the given one."""
    N, _, K = problem.shape
    scale = np.broadcast_to(sizes[:, None], (N, K))
    if problem.weights is not None:
        scale = scale / np.sqrt(problem.weights)
    if problem.active is not None:
        scale = scale * problem.active
    found = np.einsum("nkij,nkj,nk->nki", axes, f, scale)
    residual = problem.b - np.einsum("nij,nj->ni", problem.G, found.reshape(N, 3 * K))
    feasible = np.sqrt(np.einsum("ni,ni->n", residual, residual)) <= FEASIBLE * sizes
    return Forces(found, np.zeros((N, 0)), residual, feasible, np.ones(N, dtype=bool))
