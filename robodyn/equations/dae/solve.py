"""Accelerations and reactions at once, from the saddle-point system; and what eliminating the reactions leaves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from robodyn.equations.dae.consistent import arcs_of, flat_speeds
from robodyn.equations.dae.posed import Posed, own_rates
from robodyn.equations.dae.state import accelerations_of, state_of
from robodyn.equations.dae.system import Matrices
from robodyn.programs.linear import min_norm_solution, null_space
from robodyn.programs.vectors import narrowed, product
from robodyn.support.floats import Floats

DEPENDENT = 1e-10
"""A row is dependent if less than this part of it is left outside the span of the rows before it."""
BLOCK = 24
"""Rows."""
SHRUNK = 0.1
"""Of a row that had the length 1."""


class Rank(NamedTuple):
    """The independent rows, the dependent ones, and an orthonormal basis of the span of all, as rows."""

    independent: Floats
    dependent: Floats
    basis: Floats


def ranked(rows: Floats) -> Rank:
    """Return the rows one after another: each is independent unless it lies in the span of those before it.

    Gram and Schmidt's orthogonalisation, in blocks of rows for what came before the block; what is left of a row is
    taken again where it is little (Kahan and Parlett: "twice is enough").

    Args:
        rows: (m, n).
    """
    m, n = rows.shape
    basis = np.zeros((min(m, n), n))
    independent: list[int] = []
    dependent: list[int] = []
    sizes = np.sqrt((rows * rows).sum(axis=1))
    for start in range(0, m, BLOCK):
        first = len(independent)
        block = rows[start : start + BLOCK] / np.where(sizes > 0.0, sizes, 1.0)[start : start + BLOCK, None]
        for k, row in enumerate(_outside(block, basis[:first]), start):
            rest = _outside(row, basis[first : len(independent)])
            if product(rest, rest) < SHRUNK**2:
                rest = _outside(rest, basis[: len(independent)])
            left = np.sqrt(product(rest, rest))
            if left <= DEPENDENT or len(independent) == len(basis):
                dependent.append(k)
            else:
                basis[len(independent)] = rest / left
                independent.append(k)
    return Rank(np.array(independent, dtype=int), np.array(dependent, dtype=int), basis[: len(independent)])


def _outside(rows: Floats, basis: Floats) -> Floats:
    """Return what of rows lies outside the span of an orthonormal basis."""
    return np.asarray(rows - product(rows, basis.T, basis))


SINGULAR = 1e-14
"""The saddle-point matrix, with rows and columns of like size, is singular below this ratio of singular values."""
REFINEMENTS = 2
BALANCED = 8


class Solution(NamedTuple):
    """What solves the saddle-point system.

    Attributes:
        a: (6N,) accelerations (wd, dv/dt) of the bodies.
        reactions: (m,) [N and N m]; 0 for redundant equations.
    """

    a: Floats
    reactions: Floats


def scaled_rows(G: Floats, length: float) -> Floats:
    """G with angles counted as arcs of this length, and each row of length 1; its rank has then no unit."""
    rows = G * arcs_of(G.shape[1] // 6, length)
    sizes = np.sqrt((rows * rows).sum(axis=1))
    return np.asarray(rows / np.where(sizes > 0.0, sizes, 1.0)[:, None])


def rank_of(G: Floats, length: float) -> Rank:
    """Rank of G, and which of its rows are redundant."""
    return ranked(scaled_rows(G, length))


def saddle(M: Floats, G: Floats) -> Floats:
    """Return the matrix [[M, G^T], [G, 0]]."""
    m, n = G.shape
    K = np.zeros((n + m, n + m))
    K[:n, :n], K[n:, :n], K[:n, n:] = M, G, G.T
    return K


def equilibrated(K: Floats) -> tuple[Floats, Floats]:
    """Return a symmetric matrix whose rows and columns have largest entries near 1, and the factors that made it so.

    Source: Ruiz, *A scaling algorithm to equilibrate both rows and columns norms in matrices* (2001).
    """
    factors = np.ones(len(K))
    for _ in range(BALANCED):
        largest = np.abs(K).max(axis=1, initial=0.0)
        step = 1.0 / np.sqrt(np.where(largest > 0.0, largest, 1.0))
        K, factors = step[:, None] * K * step, factors * step
    return K, factors


def solved(found: Matrices, rank: Rank) -> Solution | None:
    """a and reactions of `M a - G^T reactions = f`, `G a = gamma`; None where nothing resists some motion.

    The matrix [[M, G^T], [G, 0]] of (a, -reactions) is symmetric. It is solved for independent rows of G by elimination
    with residuals in long double; the others, which then hold by themselves, have no reactions.

    Accuracy: accelerations within 1e-12 of the largest of their unit up to the condition of the mass matrix.
    """
    rows = rank.independent
    G, n = found.G[rows], len(found.f)
    K, factors = equilibrated(saddle(found.M, G))
    right = factors * np.concatenate((found.f, found.gamma[rows]))
    try:
        inverse = np.linalg.solve(K, np.eye(len(K)))
    except np.linalg.LinAlgError:
        return None
    if 1.0 / (np.abs(K).sum(axis=1).max() * np.abs(inverse).sum(axis=1).max()) < SINGULAR:
        return None
    x = product(inverse, right)
    exact, target = K.astype(np.longdouble), right.astype(np.longdouble)
    for _ in range(REFINEMENTS):
        x = x + product(inverse, (target - product(exact, x)).astype(float))
    x = factors * x
    a, reactions = x[:n], np.zeros(len(found.G))
    reactions[rows] = -x[n:]
    return Solution(a, reactions)


LOOSE = 1e-10
"""Equations of loops of which no more than this part of the largest is left follow from the others."""


@dataclass(frozen=True, eq=False)
class Reduced:
    """What is left after the elimination.

    Attributes:
        J: (6N, n) velocity transformation, v = J qd.
        drift: (6N,) accelerations where qdd = 0.
        M, free: (n, n), (n,) `M qdd = free` with free = J^T (f - M drift), tau less the bias; loops aside.
        G, gamma: (l, n), (l,) of loops, `G qdd = gamma`; no rows without loops.
    """

    J: Floats
    drift: Floats
    M: Floats
    free: Floats
    G: Floats
    gamma: Floats


def reduced(robot: Posed) -> Reduced:
    """J from the motion of the joints, one at a time, and the projections J^T M J and J^T (f - M drift)."""
    J, drift = velocity_transformation(robot), accelerations_at_rest(robot)
    found, rows = robot.matrices, robot.system.tree
    return Reduced(
        J,
        drift,
        product(J.T, found.M, J),
        product(J.T, found.f - product(found.M, drift)),
        product(found.G[rows:], J),
        found.gamma[rows:] - product(found.G[rows:], drift),
    )


def velocity_transformation(robot: Posed) -> Floats:
    """J(q): column k has the speeds of all bodies where coordinate k alone moves, at 1 per second."""
    model, sample = robot.model, robot.sample
    columns = [flat_speeds(state_of(model, robot.system.centres, sample.q, unit)) for unit in np.eye(model.n).tolist()]
    return np.stack(columns, axis=1)


def accelerations_at_rest(robot: Posed) -> Floats:
    """Jdot qd: the accelerations of all bodies where no coordinate accelerates."""
    model, sample = robot.model, robot.sample
    each = accelerations_of(model, robot.system.centres, sample.q, sample.qd, (0.0,) * model.n)
    return narrowed(np.concatenate([part for pair in each for part in pair]))


def independent_accelerations(left: Reduced) -> Floats:
    """qdd of what is left, without the reactions of loops: `qdd = q_p + N z`, `N^T M N z = N^T (free - M q_p)`.

    The columns of N span the motions that loops allow, G N = 0, and G q_p = gamma.
    """
    if not len(left.G):
        return np.asarray(np.linalg.solve(left.M, left.free))
    N, start = null_space(left.G, LOOSE).T, min_norm_solution(left.G, left.gamma, LOOSE)
    z = np.linalg.solve(product(N.T, left.M, N), product(N.T, left.free - product(left.M, start)))
    return np.asarray(start + product(N, z))


def accelerations_along(robot: Posed, solution: Solution) -> Floats:
    """qdd out of the accelerations of the bodies."""
    found = robot.matrices
    return np.array(own_rates(robot.model, robot.system, list(product(found.S, solution.a) + found.sigma)))
