"""What is asked of contact forces, and what is found: arrays alone, no robot."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.support.floats import Floats

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class TorqueTerms:
    """Torques tau = tau0 - T f - S x of m joints: their cost 1/2 sum w tau^2, and their limits (m,), which may be
    infinite; T is (N, m, 3 K)."""

    tau0: Floats
    T: Floats
    weights: Floats
    limits: Floats | None = None


@dataclass(frozen=True)
class FreeTerms:
    """Unknowns x without a sign, such as the forces of loops, in equations and torques.

    Attributes:
        H: (N, R, L), what they add to the equations: G f + H x = b.
        S: (N, m, L), what they take from the torques; None: nothing.
        weight: of their cost 1/2 weight |x|^2.
    """

    H: Floats
    S: Floats | None = None
    weight: float = 1e-9


@dataclass(frozen=True)
class Problem:
    """Forces f_k at K points, of N samples: G f = b, |f_t| <= mu f_n, f_n >= 0, at least cost.

    The cost is 1/2 sum c_k |f_k|^2, and that of the torques. Where no such forces are, |b - G f| is least first.

    Attributes:
        G: (N, R, 3 K), by components of f_1, f_2, ...
        b: (N, R); rows of G and b are in units in which a residual of one row weighs as much as one of any other.
        normals: (K, 3) or (N, K, 3), of length 1, to the side on which the robot is.
        friction: (K,) or (N, K), mu; may be 0 or infinite.
        active: (N, K); None: all. Where it is False f is 0.
        weights: (K,), c > 0; None: 1.
    """

    G: Floats
    b: Floats
    normals: Floats
    friction: Floats
    active: Flags | None = None
    weights: Floats | None = None
    torques: TorqueTerms | None = None
    free: FreeTerms | None = None

    @property
    def shape(self) -> tuple[int, int, int]:
        """N, R and K."""
        samples, rows, columns = self.G.shape
        return samples, rows, columns // 3

    @property
    def plain(self) -> bool:
        """Whether nothing but the contact forces is unknown or costs."""
        return self.torques is None and self.free is None

    def chosen(self, rows: Any) -> Problem:
        """The problem of some samples."""
        torques, free = self.torques, self.free
        if torques is not None:
            torques = replace(torques, tau0=torques.tau0[rows], T=torques.T[rows])
        if free is not None:
            free = replace(free, H=free.H[rows], S=None if free.S is None else free.S[rows])
        return replace(
            self,
            G=self.G[rows],
            b=self.b[rows],
            normals=self.normals if self.normals.ndim == 2 else self.normals[rows],
            friction=self.friction if self.friction.ndim == 1 else self.friction[rows],
            active=None if self.active is None else self.active[rows],
            torques=torques,
            free=free,
        )


@dataclass(frozen=True)
class Forces:
    """What was found.

    Attributes:
        f: (N, K, 3), on the robot, in the axes of the normals.
        free: (N, L), the unknowns x; L is 0 where there are none.
        residual: (N, R), b - G f - H x.
        feasible: (N,), whether |residual| <= FEASIBLE |b|.
        within_limits: (N,), False where torques had to exceed their limits.
    """

    f: Floats
    free: Floats
    residual: Floats
    feasible: Flags
    within_limits: Flags

    def chosen(self, rows: Any) -> Forces:
        """The forces of some samples."""
        return Forces(*(getattr(self, each.name)[rows] for each in fields(self)))


FEASIBLE = 1e-9
"""Of |b|: a larger residual says that the equations have no solution inside the cones."""


def axes_of(normals: Floats) -> Floats:
    """Return rotations (..., 3, 3) whose columns are two tangents and the normal (..., 3).

    Method: Duff and others, Building an orthonormal basis, revisited (2017).
    """
    x, y, z = np.moveaxis(normals, -1, 0)
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    first = np.stack((1.0 + sign * x * x * a, sign * b, -sign * x), -1)
    second = np.stack((b, sign + y * y * a, -y), -1)
    return np.stack((first, second, normals), -1)
