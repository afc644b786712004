"""Physically consistent parameters: what bodies that can exist have, near a description where the log says nothing."""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.regressor import INERTIAL
from robodyn.errors import InputError
from robodyn.identification.parameters.prior import Prior, parameters_of, pseudo_inertia
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

MARGIN = 1e-6
"""P - MARGIN P0 is positive definite, so that rounding in print makes no body impossible."""
_FLOOR = 1e-12
"""The least strength, in parts of ||z||^2, and the weight of the barriers of bounds where the path ends."""
_SIGNS = {"viscous": 1.0, "coulomb": 1.0, "forward": 1.0, "backward": -1.0, "stribeck": 1.0, "load": 1.0, "rotor": 1.0}
_NEXT, _CENTRED, _SETTLED = 0.05, 1.0, 1e-8
"""By which the barrier weakens; squares of Newton's decrement, in units of the barrier, up to which it does, and up to
which the last point is the minimum."""
_STEPS, _LAST = 400, 12
"""Newton's steps at most, and those at the end of the path after which what is left is rounding."""
BASIS = np.zeros((10, 4, 4))
"""An orthonormal basis (10, 4, 4) of the symmetric matrices."""
for _k, (_i, _j) in enumerate(zip(*np.triu_indices(4), strict=True)):
    BASIS[_k, _i, _j] = BASIS[_k, _j, _i] = 1.0 if _i == _j else 0.5**0.5
_ONE = einsum("kii->k", BASIS)
"""The coordinates of the identity."""


def coordinates(V: Floats) -> Floats:
    """Return the coordinates (..., 10) of symmetric matrices (..., 4, 4) in `BASIS`."""
    v: Floats = einsum("kij,...ij->...k", BASIS, V)
    return v


class ConsistentFit(NamedTuple):
    """Physically consistent parameters theta (p,), with `error` = ||R theta - z||^2 / 2.

    Attributes:
        gap: by how much the objective exceeds its minimum at most; infinite if that could not be found.
    """

    theta: Floats
    error: float
    gap: float


def consistent_parameters(R: Floats, z: Floats, prior: Prior, strength: float = 0.0) -> ConsistentFit:
    """Return the parameters of possible bodies that minimise the squares and the distance from the prior, together.

    The minimum of

        ||R theta - z||^2 / 2 + strength (sum over bodies of D(P || P0) + sum over the others of ((x - x0) / s)^2 / 2)

    over P positive definite with tr(P Q) >= 0 where a body has a bounding ellipsoid, viscous, coulomb, forward,
    stribeck and rotor >= 0, backward <= 0. D is the log-determinant divergence of what exceeds `MARGIN` P0 from what P0
    has of that (Lee, Wensing, Park 2020), which does not depend on units, axes or masses; s is |x0| or what alone would
    make ||z||, whichever is larger. Without strength the least that is computed with is 1e-12 ||z||^2: of all fits as
    good as any this is the one nearest to the prior. Parameters that the rows do not show keep the description's
    values.

    Method: Newton's along the path of a weakening barrier (see `_Path`), in variables V with P = L V L^T, P0 = L L^T,
    and x / s. The objective is its own barrier of the bodies: it is self-concordant, and Newton's decrement bounds how
    far its minimum is (Boyd and Vandenberghe 2004, 9.6).

    Args:
        R, z: (rows, p), (rows,), as triangular factors of a weighted regressor and torques.
        strength: of the prior, in the unit of ||z||^2.

    Raises:
        InputError: a number is not finite.

    Accuracy: the objective is within 2e-12 (k + 1) ||z||^2 of its minimum, with k bounds; `gap` says it.
    """
    if not (np.isfinite(R).all() and np.isfinite(z).all()):
        raise InputError("the rows have numbers that are not finite", remedy="look for gaps in the log")
    path = _Path(R, z, prior, strength)
    if not path.seen.any():
        return ConsistentFit(prior.described.copy(), float(z @ z) / 2.0, 0.0)
    gap = path.follow()
    theta = path.theta()
    residual = R @ theta - z
    return ConsistentFit(theta, float(residual @ residual) / 2.0, gap * path.size**2)


class _Path:
    """theta = offset + T y of the parameters that the rows show, so that prior and rows are of the order of 1.

    P = MARGIN P0 + (1 - MARGIN) L V L^T of each body, V by its coordinates, then the other parameters in units of
    their own. At mu y minimises

        ||A y - b||^2 / 2 + lam ||x - x0||^2 / 2 + lam tr V - (lam + mu - floor) log det V - mu sum log(G y + h)

    where mu falls to the floor.
    """

    def __init__(self, R: Floats, z: Floats, prior: Prior, strength: float) -> None:
        self.prior, self.offset = prior, prior.described.copy()
        self.seen = (R != 0.0).any(axis=0)
        self.bodies = [body for body in prior.bodies if self.seen[body.columns].any()]
        columns = np.linalg.norm(R, axis=0)
        self.size = float(np.linalg.norm(z, axis=0)) or float(columns.max(initial=0.0)) or 1.0
        self.lam = max(strength / self.size**2, _FLOOR)
        kinds = [name.rpartition(".")[2] for name in prior.names]
        others = np.array([k for k, kind in enumerate(kinds) if self.seen[k] and kind not in INERTIAL], dtype=int)
        signs = np.array([_SIGNS.get(kinds[k], 0.0) for k in others])
        units = np.maximum(np.abs(prior.theta[others]), self.size / columns[others])
        units[signs < 0.0] *= -1.0
        self.offset[others] = 0.0
        self.inner = 10 * len(self.bodies)
        self.signed = np.flatnonzero(signs) + self.inner
        self.T = np.zeros((len(R.T), self.inner + len(others)))
        self.T[others, np.arange(self.inner, len(self.T.T))] = units
        G, h = [np.eye(len(self.T.T))[self.signed]], [0.0] * len(self.signed)
        for k, body in enumerate(self.bodies):
            L = np.linalg.cholesky(pseudo_inertia(prior.theta[body.columns]))
            own = slice(10 * k, 10 * k + 10)
            self.T[body.columns, own] = (1.0 - MARGIN) * parameters_of(L @ BASIS @ L.T).T
            self.offset[body.columns] = MARGIN * prior.theta[body.columns]
            if body.ellipsoid is not None:
                row, Q = np.zeros((1, len(self.T.T))), L.T @ body.ellipsoid @ L
                row[0, own] = (1.0 - MARGIN) * coordinates(Q)
                G.append(row)
                h.append(MARGIN * float(np.trace(Q)))
        self.A, self.b = R @ self.T / self.size, (z - R @ self.offset) / self.size
        self.G, self.ones = np.concatenate(G), np.tile(_ONE, len(self.bodies))
        self.y = np.concatenate((self.ones, prior.theta[others] / units))
        self.y[self.signed] = np.maximum(self.y[self.signed], 0.0)
        self.centre = self.y[self.inner :].copy()
        self.y[self.signed] = np.maximum(self.y[self.signed], 1e-3)
        self.slack = self.G @ self.y + h

    def theta(self) -> Floats:
        """Return the parameters; those at their bound are 0."""
        y, slack = self.y.copy(), self.slack[: len(self.signed)]
        y[self.signed] = np.where(slack * slack < _FLOOR, 0.0, slack)
        theta: Floats = self.offset + self.T @ y
        return theta

    def follow(self) -> float:
        """Go to the end of the path; return by how much the objective exceeds its minimum at most."""
        error = self.A @ self.y - self.b
        mu, at_end = max(1e-2, float(error @ error)), 0
        for _ in range(_STEPS):
            squared = self._step(mu)
            if mu > _FLOOR:
                mu = max(_FLOOR, _NEXT * mu) if squared < _CENTRED * mu else mu
                continue
            at_end += 1
            if squared < min(_SETTLED * self.lam, _FLOOR) or at_end > _LAST:
                return squared + len(self.slack) * _FLOOR
        return inf

    def _step(self, mu: float) -> float:
        """Go by Newton's direction to where the objective is least along it; return the square of the decrement.

        In variables u with V + dV = F (1 + dU) F^T, V = F F^T, and signed ones in parts of themselves, the second
        derivatives of barriers are multiples of the identity, and those of everything are rows^T rows.
        """
        from scipy.linalg import solve_triangular

        n, curve = self.inner, self.lam + mu - _FLOOR
        F = np.linalg.cholesky(einsum("lk,kij->lij", self.y[:n].reshape(-1, 10), BASIS))
        S = np.swapaxes(coordinates(F[:, None] @ BASIS @ np.swapaxes(F, -1, -2)[:, None]), -1, -2)
        unit = np.ones(len(self.y) - n)
        unit[self.signed - n] = self.slack[: len(self.signed)]

        def scaled(rows: Floats) -> Floats:
            blocks = rows[:, :n].reshape(len(rows), len(self.bodies), 1, 10) @ S
            return np.concatenate((blocks.reshape(len(rows), n), rows[:, n:] * unit), axis=1)

        nearing, root = scaled(self.G) / self.slack[:, None], np.sqrt(self.lam)
        own = np.concatenate((np.full(n, np.sqrt(curve)), root * unit))
        rows = np.concatenate((scaled(self.A), np.diag(own), np.sqrt(mu) * nearing))
        trace = (self.ones.reshape(-1, 1, 10) @ S).ravel()
        off = np.concatenate(
            (
                self.A @ self.y - self.b,
                (self.lam * trace - curve * self.ones) / np.sqrt(curve),
                root * (self.y[n:] - self.centre),
                np.full(len(self.slack), -np.sqrt(mu)),
            )
        )
        triangle = np.asarray(np.linalg.qr(np.column_stack((rows, off)), mode="r"))
        along = triangle[: len(self.y), -1]
        u = -solve_triangular(triangle[: len(self.y), :-1], along)
        bends = np.linalg.eigvalsh(einsum("lk,kij->lij", u[:n].reshape(-1, 10), BASIS)).ravel()
        approach = nearing @ u
        smooth = np.concatenate((rows[: len(self.A)] @ u, root * unit * u[n:]))
        slope = (
            smooth @ np.concatenate((off[: len(self.A)], root * (self.y[n:] - self.centre))) + self.lam * trace @ u[:n]
        )
        barriers = np.concatenate((np.full(len(bends), curve), np.full(len(approach), mu)))
        part = _least(float(slope), float(smooth @ smooth), barriers, np.concatenate((bends, approach)))
        self.y = self.y + part * np.concatenate(((S @ u[:n].reshape(-1, 10, 1)).ravel(), unit * u[n:]))
        self.slack = self.slack * (1.0 + part * approach)
        return float(along @ along)


def _least(slope: float, bend: float, weights: Floats, rates: Floats) -> float:
    """Minimiser t > 0 of slope t + bend t^2 / 2 - sum weights log(1 + t rates), by Newton steps in a bracket."""
    low, high = 0.0, -1.0 / float(rates.min()) if rates.min(initial=0.0) < 0.0 else 1e3
    t = min(1.0, 0.9 * high)
    for _ in range(30):
        parts = rates / (1.0 + t * rates)
        first = slope + bend * t - float(weights @ parts)
        low, high = (low, t) if first > 0.0 else (t, high)
        new = t - first / (bend + float(weights @ (parts * parts)))
        new = new if low < new < high else 0.5 * (low + high)
        if abs(new - t) < 1e-3 * t:
            return new
        t = new
    return t
