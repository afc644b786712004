"""Newton's equations of the central path `V Z = (lam + mu - floor) 1`, `s w = mu >= floor` of a `Problem`.

Scaled as Nesterov and Todd do (1997): with F, V = F D F^T and Z = F^-T D F^-1 have the same diagonal D, and the
equations of the matrices' directions are dV + dZ = (lam + mu - floor) D^-1 - D.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robodyn.identification.cones import BASIS, Point, Problem, coordinates, matrices
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

_KEEP = 0.98
"""The part of the way to the border of the cones that a step goes at most."""
_CENTRED = 1e-4


class Direction(NamedTuple):
    """A step of y; of V and Z in the axes in which both are diagonal; of s and w."""

    y: Floats
    V: Floats
    Z: Floats
    s: Floats
    w: Floats


class Newton:
    """Newton's equations at a point.

    Method: normal equations in the scaled variables, where the matrices add the identity, and Cholesky's factors, or QR
    where rounding leaves none; what it does to a step the next one corrects.

    Attributes:
        mu: where on the path the point is, by the mean of its products.
        decrement: sqrt(r H^-1 r), where r is the error of the gradient's equation: half its square is what that costs.

    Raises:
        numpy.linalg.LinAlgError: the equations cannot be solved in floats.
    """

    def __init__(self, problem: Problem, point: Point) -> None:
        self.problem, self.point = problem, point
        L, M = np.linalg.cholesky(point.V), np.linalg.cholesky(point.Z)
        _, self.d, turn = np.linalg.svd(np.swapaxes(M, -1, -2) @ L)
        self.F = L @ np.swapaxes(turn, -1, -2) / np.sqrt(self.d)[:, None, :]
        moved = self.F[:, None] @ BASIS @ np.swapaxes(self.F, -1, -2)[:, None]
        self.S = np.swapaxes(coordinates(moved), -1, -2)
        self.mu = float(np.mean((*(self.d * self.d - problem.lam + problem.floor).ravel(), *(point.s * point.w))))
        self.gradient = self._scaled(problem.gradient(point.y))
        self.G = self._scaled(problem.G)
        self.ratio = point.w / point.s
        own = np.where(np.arange(len(point.y)) < problem.size, 1.0, problem.ridge)
        rows = np.concatenate((self._scaled(problem.A), np.sqrt(self.ratio)[:, None] * self.G))
        self.inverse_root = np.linalg.inv(_root(rows, own))
        dual = self.gradient - self.G.T @ point.w - self._padded(_diagonal(self.d))
        self.decrement = float(np.linalg.norm(self.inverse_root @ dual, axis=0))

    def _scaled(self, rows: Floats) -> Floats:
        """Return rows (..., p) times what leads from the scaled variables to y."""
        n = self.problem.size
        blocks = rows[..., :n].reshape(*rows.shape[:-1], self.problem.count, 1, 10) @ self.S
        return np.concatenate((blocks.reshape(*rows.shape[:-1], n), rows[..., n:]), axis=-1)

    def _padded(self, X: Floats) -> Floats:
        """Return matrices as variables, the others zero."""
        others = np.zeros(len(self.point.y) - self.problem.size)
        return np.concatenate((coordinates(X).ravel(), others))

    @property
    def gap(self) -> float:
        """F(y) - F* <= lam sum (z - 1 - log z) + sum s w + decrement^2 / 2, with z the eigenvalues of V Z / lam.

        F is convex: F(y') >= F(y) + <Z, V' - V> - lam log det(V' V^-1) + w (s' - s), which is least at V' = lam Z^-1,
        s' = 0, where the gradient is that of Z and w; its error costs half the square of the decrement.
        """
        lam, off = self.problem.lam, self.d * self.d / self.problem.lam - 1.0
        with np.errstate(divide="ignore"):
            apart = lam * np.sum(off - np.log1p(off)) + np.sum(self.point.s * self.point.w)
        return float(apart) + self.decrement**2 / 2.0

    @property
    def certain(self) -> bool:
        """Whether the gap is what the floor leaves of it."""
        return self.gap <= 2.0 * (len(self.point.s) + 1) * self.problem.floor

    @property
    def centred(self) -> bool:
        """Whether the matrices are where the path ends, also where the rows do not hold them."""
        return bool(np.abs(self.d * self.d / self.problem.lam - 1.0).max(initial=0.0) <= _CENTRED)

    @property
    def feasible(self) -> bool:
        """Whether the gradient's equation holds as well as the point is centred."""
        return self.decrement <= float(np.sqrt(self.problem.lam + max(self.mu, self.problem.floor)))

    def direction(self, mu: float, foreseen: Direction | None = None) -> Direction:
        """Return the step to the path at mu; with the second-order term of a step that was foreseen (Mehrotra 1992)."""
        problem, point, d = self.problem, self.point, self.d
        goal, slack = _diagonal((problem.lam + mu - problem.floor) / d), mu / point.s
        if foreseen is not None:
            both = foreseen.V @ foreseen.Z
            goal = goal - (both + np.swapaxes(both, -1, -2)) / (d[:, :, None] + d[:, None, :])
            slack = slack - foreseen.s * foreseen.w / point.s
        outside = problem.G @ point.y + problem.h - point.s
        right = self._padded(goal) - self.gradient + self.G.T @ (slack - self.ratio * outside)
        v = self.inverse_root.T @ (self.inverse_root @ right)
        links, n = v[: problem.size].reshape(-1, 10), problem.size
        y = np.concatenate((einsum("lab,lb->la", self.S, links).ravel(), v[n:]))
        V, s = matrices(links), problem.G @ y + outside
        return Direction(y, V, goal - _diagonal(d) - V, s, slack - point.w - self.ratio * s)

    def reach(self, step: Direction) -> float:
        """Return how much of a step can be taken, at most 1: the same of y and the multipliers, which A^T A joins."""
        root = np.sqrt(self.d)
        units = root[:, :, None] * root[:, None, :]
        cones = np.linalg.eigvalsh(np.concatenate((step.V / units, step.Z / units)))
        slopes = np.concatenate((cones.ravel(), step.s / self.point.s, step.w / self.point.w))
        return _KEEP / max(_KEEP, -float(slopes.min()))

    def stepped(self, step: Direction) -> Point:
        """Return the point behind as much of a step as can be taken."""
        part, point = self.reach(step), self.point
        y, back = point.y + part * step.y, np.linalg.inv(self.F)
        Z = np.swapaxes(back, -1, -2) @ (_diagonal(self.d) + part * step.Z) @ back
        symmetric = (Z + np.swapaxes(Z, -1, -2)) / 2.0
        return Point(y, self.problem.matrices(y), symmetric, point.s + part * step.s, point.w + part * step.w)


def _root(rows: Floats, own: Floats) -> Floats:
    """Return L, lower triangular, with L L^T = rows^T rows + diag(own).

    The product is not BLAS's, whose threads wait for each other where others use the cores: here 20 times as long.
    """
    try:
        return np.asarray(np.linalg.cholesky(einsum("ka,kb->ab", rows, rows) + np.diag(own)))
    except np.linalg.LinAlgError:
        R = np.asarray(np.linalg.qr(np.concatenate((rows, np.diag(np.sqrt(own)))), mode="r"))
        return R.T


def _diagonal(d: Floats) -> Floats:
    return d[:, :, None] * np.eye(4)
