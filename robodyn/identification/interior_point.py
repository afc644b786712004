"""The minimiser of a `Problem`, by a primal-dual interior-point method."""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

from robodyn.identification.cones import Point, Problem
from robodyn.identification.newton import Newton
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

_MOST = 100
_SHORT = 0.1
"""A step that can be taken no farther is left for one back to the middle of the path."""
_PATIENCE = 8
"""Steps at the end of the path after which what is left is rounding."""


class Minimum(NamedTuple):
    """The minimiser.

    Attributes:
        y: (p,).
        s, w: (k,) slacks of the half-spaces and their multipliers.
        gap: by how much the objective exceeds its least value at most; infinite if that is not known.
        steps: of Newton's method.
    """

    y: Floats
    s: Floats
    w: Floats
    gap: float
    steps: int


def minimised(problem: Problem, y: Floats) -> Minimum:
    """Return the minimiser.

    Method: steps along the central path, mu falling with what a step towards its end can reach (Mehrotra 1992), but not
    before the gradient's equation holds as well.

    Args:
        y: to begin with; its matrices are positive definite.

    Accuracy: the objective exceeds its minimum by `gap`, 2 (k + 1) floor at most where the steps settle.
    """
    error = einsum("ij,j->i", problem.A, y) - problem.b
    mu = max(1e-2, float(np.sum(error * error)))
    V = problem.matrices(y)
    s = np.maximum(einsum("ij,j->i", problem.G, y) + problem.h, 1e-3)
    Z = np.asarray((problem.lam + mu) * np.linalg.inv(V), dtype=float)
    point = Point(y, V, Z, s, mu / s)
    at_end = 0
    for steps in range(_MOST):
        try:
            newton = Newton(problem, point)
        except np.linalg.LinAlgError:
            break
        at_end += mu <= problem.floor
        if newton.certain and (newton.centred or at_end > _PATIENCE):
            return Minimum(point.y, point.s, point.w, newton.gap, steps)
        mu = max(problem.floor, min(mu, newton.mu))
        foreseen = None
        if mu > problem.floor:
            foreseen = newton.direction(0.0)
            if newton.feasible:
                mu = max(problem.floor, mu * max((1.0 - newton.reach(foreseen)) ** 2, 0.1))
        step = newton.direction(mu, foreseen)
        if newton.reach(step) < _SHORT:
            mu = max(mu, newton.mu)
            step = newton.direction(mu)
        point = newton.stepped(step)
    return Minimum(point.y, point.s, point.w, inf, steps)
