"""The mean of (n . x)^k over a body as a polynomial in the direction n."""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial

import numpy as np

from robodyn.programs.vectors import Array
from robodyn.solids.mesh.symmetry.higher_moments import determinants
from robodyn.support.floats import Floats

_BLOCK = 512


@dataclass(frozen=True, eq=False)
class EvenForm:
    """The sum of factor * x^i y^j z^k with i + j + k the degree.

    Attributes:
        powers: (m, 3) i, j, k.
        factors: (m,).
    """

    powers: Array
    factors: Floats

    @classmethod
    def of(cls, corners: Array, degree: int) -> EvenForm:
        """Return the integral of (n . x)^degree, degree up to 6, over the tetrahedra from the origin to triangles.

        Lengths are in units of the largest distance of a corner.

        Args:
            corners: (m, 3, 3) about the centre.
        """
        powers = np.array([(i, j, degree - i - j) for i in range(degree + 1) for j in range(degree + 1 - i)])
        reach = np.sqrt((corners**2).sum(axis=2).max())
        sums = np.zeros(len(powers))
        for start in range(0, len(corners), _BLOCK):
            sums += _sums(corners[start : start + _BLOCK] / reach, powers)
        ways = [factorial(degree) // (factorial(i) * factorial(j) * factorial(k)) for i, j, k in powers.tolist()]
        return cls(powers, sums / (degree + 3) * ways)

    def derivatives(self, n: Array) -> tuple[Floats, Floats]:
        """Gradients (m, 3) and Hessians (m, 3, 3) at directions (m, 3)."""
        gradient, hessian = np.empty(n.shape), np.empty((*n.shape, 3))
        for i in range(3):
            first = self._along(i)
            gradient[:, i] = first._at(n)
            for j in range(i + 1):
                hessian[:, i, j] = hessian[:, j, i] = first._along(j)._at(n)
        return gradient, hessian

    def _along(self, i: int) -> EvenForm:
        """Return the derivative in one coordinate."""
        lower = self.powers.copy()
        lower[:, i] = np.maximum(lower[:, i] - 1, 0)
        return EvenForm(lower, self.factors * self.powers[:, i])

    def _at(self, n: Array) -> Floats:
        found: Floats = (np.prod(_powers(n)[:, self.powers, np.arange(3)], axis=2) * self.factors).sum(axis=1)
        return found


def _sums(corners: Array, powers: Array) -> Floats:
    """(m,) integrals of the products of coordinates with these powers over triangles of twice the area D."""
    points = np.einsum("qc,mcx->qmx", _SHARES, corners)
    products = np.prod(_powers(points)[:, :, powers, np.arange(3)], axis=3)
    found: Floats = (products * (_WEIGHTS[:, None] * determinants(corners))[:, :, None]).sum(axis=(0, 1))
    return found


def _powers(x: Array) -> Array:
    """(..., 7, 3) powers 0 to 6 of coordinates (..., 3)."""
    return np.cumprod(np.concatenate([np.ones((*x.shape[:-1], 1, 3)), *[x[..., None, :]] * 6], axis=-2), axis=-2)


def _folded() -> tuple[Floats, Floats]:
    """Shares (16, 3) of the corners of a triangle and weights (16,): Gauss's rule of four points, exact to degree 7,
    in each direction of a square that is folded to a triangle of area 1/2 (Duffy)."""
    near, far = np.sqrt(3 / 7 - 2 / 7 * np.sqrt(6 / 5)), np.sqrt(3 / 7 + 2 / 7 * np.sqrt(6 / 5))
    x = (1 + np.array((-far, -near, near, far))) / 2
    outer, inner = (18 - np.sqrt(30.0)) / 72, (18 + np.sqrt(30.0)) / 72
    w = np.array((outer, inner, inner, outer))
    u, v = np.repeat(x, 4), np.tile(x, 4)
    b, c = u, v * (1 - u)
    return np.stack([1 - b - c, b, c], axis=1), np.repeat(w * (1 - x), 4) * np.tile(w, 4)


_SHARES, _WEIGHTS = _folded()
