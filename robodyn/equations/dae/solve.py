"""Accelerations and reactions at once, from the saddle-point system of Newton's, Euler's and constraint equations."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robodyn.equations.dae.system import Matrices
from robodyn.programs.linear import solve
from robodyn.programs.vectors import product
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
    """The rows one after another: each is independent unless it lies in the span of those before it.

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
    """What of rows lies outside the span of an orthonormal basis."""
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
    arcs = np.tile(np.repeat((1.0 / length, 1.0), 3), G.shape[1] // 6)
    rows = G * arcs
    sizes = np.sqrt((rows * rows).sum(axis=1))
    return np.asarray(rows / np.where(sizes > 0.0, sizes, 1.0)[:, None])


def rank_of(G: Floats, length: float) -> Rank:
    """Rank of G, and which of its rows are redundant."""
    return ranked(scaled_rows(G, length))


def saddle(M: Floats, G: Floats) -> Floats:
    """The matrix [[M, G^T], [G, 0]]."""
    m, n = G.shape
    K = np.zeros((n + m, n + m))
    K[:n, :n], K[n:, :n], K[:n, n:] = M, G, G.T
    return K


def equilibrated(K: Floats) -> tuple[Floats, Floats]:
    """A symmetric matrix whose rows and columns have largest entries near 1, and the factors that made it so.

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
        inverse = solve(K, np.eye(len(K)))
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
