"""Contact forces that alone are unknown and cost: the given problem as cones, and back."""

from __future__ import annotations

import numpy as np

from robodyn.dynamics.contacts.dual import Cones, least_forces
from robodyn.dynamics.contacts.problem import FEASIBLE, Forces, Problem
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum


def plain_forces(problem: Problem, executor: str = "auto", expected: int = 0) -> Forces:
    """Return what `contact_forces` returns, of a problem whose torques and free unknowns do not count."""
    cones, sizes = scaled(problem)
    N, _, K = problem.shape
    f, _ = least_forces(cones, executor, expected)
    found = (f.reshape(K, 3, N) * (sizes * cones.scale)[:, None]).transpose(2, 0, 1)
    residual = problem.b - einsum("nij,nj->ni", problem.G, found.reshape(N, 3 * K))
    missing = np.sqrt(einsum("ni,ni->n", residual, residual))
    return Forces(found, np.zeros((N, 0)), residual, missing <= FEASIBLE * sizes, np.ones(N, dtype=bool))


def scaled(problem: Problem) -> tuple[Cones, Floats]:
    """Return the problem with |b| = 1, weights 1 and forces of inactive points that count for nothing; and |b| (N,)."""
    N, _, K = problem.shape
    sizes = np.sqrt(einsum("ni,ni->n", problem.b, problem.b))
    scale = np.ones(K) if problem.weights is None else np.sqrt(problem.weights.max() / problem.weights)
    by_sample = scale if problem.active is None else scale * problem.active
    angle = np.arctan(problem.friction)
    cosine = np.where(np.isinf(problem.friction), 0.0, np.cos(angle))
    parts = (problem.normals.reshape(*problem.normals.shape[:-2], -1), cosine, np.sin(angle), by_sample)
    normals, cosine, sine, by_sample = (np.broadcast_to(part, (N, part.shape[-1])).T for part in parts)
    b = problem.b.T / np.where(sizes > 0.0, sizes, 1.0)
    return Cones(problem.G.reshape(N, -1).T, b, normals, cosine, sine, by_sample), sizes
