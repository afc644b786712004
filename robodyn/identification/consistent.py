"""Physically consistent parameters: what bodies that can exist have, near a description where the log says nothing."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.dynamics.regressor import INERTIAL
from robodyn.errors import InputError
from robodyn.identification.cones import BASIS, ONE, Problem, coordinates
from robodyn.identification.interior_point import Minimum, minimised
from robodyn.identification.prior import Prior
from robodyn.identification.pseudo_inertia import divergence, parameters_of, pseudo_inertia
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

MARGIN = 1e-6
"""P - MARGIN P0 is positive definite, so that rounding in print makes no body impossible."""
_FLOOR = 1e-12
"""The least strength, in parts of ||z||^2."""
_SIGNS = {"viscous": 1.0, "coulomb": 1.0, "forward": 1.0, "backward": -1.0, "stribeck": 1.0, "load": 1.0, "rotor": 1.0}


class ConsistentFit(NamedTuple):
    """Physically consistent parameters.

    Attributes:
        theta: (p,).
        error: ||R theta - z||^2 / 2.
        divergence: D, by body that the rows show.
        gap: by how much the objective exceeds its minimum at most; infinite if that could not be found.
        steps: of Newton's method.
    """

    theta: Floats
    error: float
    divergence: dict[str, float]
    gap: float
    steps: int


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

    Method: `robodyn.identification.cones`, in variables V with P = L V L^T, P0 = L L^T, and x / s.

    Args:
        R, z: (rows, p), (rows,), as triangular factors of a weighted regressor and torques.
        prior: of the p parameters.
        strength: in the unit of ||z||^2.

    Raises:
        InputError: shapes do not fit, a number is not finite, or the strength is negative.

    Accuracy: the objective is within 2e-12 (k + 1) ||z||^2 of its minimum, with k bounds; `gap` says it.
    """
    _check(R, z, prior, strength)
    scaled = _Scaled(R, z, prior)
    if not scaled.seen.any():
        return ConsistentFit(prior.described.copy(), float(einsum("i,i->", z, z)) / 2.0, {}, 0.0, 0)
    found = minimised(scaled.problem(strength), scaled.y0)
    theta = scaled.theta(found)
    residual = einsum("ij,j->i", R, theta) - z
    error = float(einsum("i,i->", residual, residual)) / 2.0
    far = {body.name: _divergence(theta[body.columns], prior.theta[body.columns]) for body in scaled.bodies}
    return ConsistentFit(theta, error, far, found.gap * scaled.size**2, found.steps)


def _divergence(parameters: Floats, prior: Floats) -> float:
    return float(divergence(pseudo_inertia(parameters), pseudo_inertia(prior)))


def _check(R: Floats, z: Floats, prior: Prior, strength: float) -> None:
    p = len(prior.names)
    if np.ndim(R) != 2 or np.shape(R)[1] != p or np.shape(z) != (len(R),):
        raise InputError(f"rows of shape {np.shape(R)} and {np.shape(z)} for {p} parameters")
    if not (np.isfinite(R).all() and np.isfinite(z).all()):
        raise InputError("the rows have numbers that are not finite", remedy="look for gaps in the log")
    if not 0.0 <= strength < np.inf:
        raise InputError(f"the strength {strength:g} is not positive or zero")


class _Scaled:
    """theta = offset + T y of the parameters that the rows show, so that prior and rows are of the order of 1.

    P = MARGIN P0 + (1 - MARGIN) L V L^T of each body, then the others by their units.
    """

    def __init__(self, R: Floats, z: Floats, prior: Prior) -> None:
        self.prior, self.offset = prior, prior.described.copy()
        self.seen = (R != 0.0).any(axis=0)
        self.bodies = [body for body in prior.bodies if self.seen[body.columns].any()]
        self.count = 10 * len(self.bodies)
        columns = np.linalg.norm(R, axis=0)
        self.size = float(np.linalg.norm(z, axis=0)) or float(columns.max(initial=0.0)) or 1.0
        links, others = self._links(), self._others(columns)
        self.offset[others] = 0.0
        self.T = np.zeros((len(self.seen), self.count + len(others)))
        for k, body in enumerate(self.bodies):
            self.T[body.columns, 10 * k : 10 * k + 10] = links[k]
            self.offset[body.columns] = MARGIN * prior.theta[body.columns]
        self.T[others, np.arange(self.count, self.T.shape[1])] = self.units
        self.y0 = np.concatenate((np.tile(ONE, len(self.bodies)), prior.theta[others] / self.units))
        self.y0[self.signed] = np.maximum(self.y0[self.signed], 0.0)
        self.A, self.b = R @ self.T / self.size, (z - R @ self.offset) / self.size

    def _links(self) -> list[Floats]:
        """Return (10, 10) for each body: its parameters of the coordinates of V."""
        self.roots = [np.linalg.cholesky(pseudo_inertia(self.prior.theta[body.columns])) for body in self.bodies]
        return [(1.0 - MARGIN) * parameters_of(L @ BASIS @ L.T).T for L in self.roots]

    def _others(self, columns: Floats) -> NDArray[np.intp]:
        """Return where the other parameters are; set their units, and which of them have a sign."""
        kinds = [name.rpartition(".")[2] for name in self.prior.names]
        others = np.array([k for k, kind in enumerate(kinds) if self.seen[k] and kind not in INERTIAL], dtype=int)
        signs = np.array([_SIGNS.get(kinds[k], 0.0) for k in others])
        self.units = np.maximum(np.abs(self.prior.theta[others]), self.size / columns[others])
        self.units[signs < 0.0] *= -1.0
        self.signed = np.flatnonzero(signs) + self.count
        return others

    def problem(self, strength: float) -> Problem:
        lam = max(strength / self.size**2, _FLOOR)
        ridge = np.where(np.arange(len(self.y0)) < self.count, 0.0, lam)
        G, h = [np.eye(len(self.y0))[self.signed]], [0.0] * len(self.signed)
        for k, (body, L) in enumerate(zip(self.bodies, self.roots, strict=True)):
            if body.ellipsoid is not None:
                row, Q = np.zeros((1, len(self.y0))), L.T @ body.ellipsoid @ L
                row[0, 10 * k : 10 * k + 10] = (1.0 - MARGIN) * coordinates(Q)
                G.append(row)
                h.append(MARGIN * float(np.trace(Q)))
        return Problem(self.A, self.b, len(self.bodies), lam, ridge, self.y0, np.concatenate(G), np.array(h), _FLOOR)

    def theta(self, found: Minimum) -> Floats:
        """Return the parameters; those at their bound are 0."""
        y, k = found.y.copy(), len(self.signed)
        y[self.signed] = np.where(found.s[:k] < found.w[:k], 0.0, found.s[:k])
        theta: Floats = self.offset + self.T @ y
        return theta
