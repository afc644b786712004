"""Least squares over positive definite matrices and half-spaces: what is minimised, and what of it is known.

    minimise    1/2 ||A y - b||^2 + 1/2 sum ridge (y - centre)^2 + lam sum over l of (tr V_l - log det V_l - 4)
    subject to  V_l positive definite, G y + h >= 0

y holds the matrices V_l (4 x 4), as coordinates in the basis `BASIS`, and then other variables.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from robodyn.support.floats import Floats
from robodyn.support.sums import einsum


def _basis() -> Floats:
    E = np.zeros((10, 4, 4))
    for k, (i, j) in enumerate(zip(*np.triu_indices(4), strict=True)):
        E[k, i, j] = E[k, j, i] = 1.0 if i == j else 0.5**0.5
    return E


BASIS = _basis()
"""An orthonormal basis (10, 4, 4) of the symmetric matrices."""
ONE = einsum("kii->k", BASIS)
"""The coordinates of the identity."""


def coordinates(V: Floats) -> Floats:
    """Return the coordinates (..., 10) of symmetric matrices (..., 4, 4) in `BASIS`."""
    v: Floats = einsum("kij,...ij->...k", BASIS, V)
    return v


def matrices(v: Floats) -> Floats:
    """Return the matrices (..., 4, 4) of coordinates (..., 10)."""
    V: Floats = einsum("...k,kij->...ij", v, BASIS)
    return V


@dataclass(frozen=True, eq=False)
class Problem:
    """What is minimised, see above; scaled so that b and the y to begin with are of the order of 1.

    Attributes:
        A, b: (rows, p), (rows,).
        count: of the matrices, the first 10 count variables.
        lam: weight of the divergences, positive.
        ridge, centre: (p,) weight of the squares and what they pull to; of matrices the ridge is zero.
        G, h: (k, p), (k,).
        floor: to which the products of slacks and multipliers are brought: k floor is what the half-spaces' borders
            add to the least that can be reached.
    """

    A: Floats
    b: Floats
    count: int
    lam: float
    ridge: Floats
    centre: Floats
    G: Floats
    h: Floats
    floor: float

    @property
    def size(self) -> int:
        """The number of variables in matrices."""
        return 10 * self.count

    def matrices(self, y: Floats) -> Floats:
        """Return V (count, 4, 4)."""
        return matrices(y[: self.size].reshape(-1, 10))

    def gradient(self, y: Floats) -> Floats:
        """Return the gradient of all but the logarithms."""
        g: Floats = self.A.T @ (self.A @ y - self.b) + self.ridge * (y - self.centre)
        g[: self.size] += self.lam * np.tile(ONE, self.count)
        return g


class Point(NamedTuple):
    """Variables y (p,) and their matrices V, multipliers Z (count, 4, 4), slacks s and their multipliers w (k,)."""

    y: Floats
    V: Floats
    Z: Floats
    s: Floats
    w: Floats
