"""The uncertain parameters of a robot, counted in standard deviations, and draws of all of them together."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from statistics import NormalDist

import numpy as np

from robodyn.dynamics.regressor import INERTIAL
from robodyn.programs.vectors import product
from robodyn.robot.load import placement
from robodyn.robot.model import Frame
from robodyn.robot.urdf.parts import Inertial
from robodyn.scene.parts import Friction
from robodyn.solids.inertia.laws import symmetric
from robodyn.support.floats import Floats
from robodyn.support.sums import einsum

OF_LINKS = ("mass", "com", "com", "com", "inertia", "inertia", "inertia", "inertia")
"""What varies of a link: mass, centre of mass along x, y and z, a factor of the inertia, and ixx, iyy and izz."""


_DRAWS, _SEED = 1000, 1900


@dataclass(frozen=True)
class Variation:
    """An uncertain parameter, and what one standard deviation of it adds, to first order.

    Attributes:
        name: "forearm.mass", "forearm.com" (of each axis), "forearm.inertia", "elbow.friction", or the regressor's.
        deviation: its standard deviation in SI units; of a factor as a share.
        body, moments: m, mc and I in the order of `INERTIAL` are added to this body; -1 and () if none are.
        joint, friction, rotor: this friction and this reflected inertia [kg m^2] are added at a joint, or to a coupled
            motor; "" if none are.
    """

    name: str
    deviation: float
    body: int = -1
    moments: tuple[float, ...] = ()
    joint: str = ""
    friction: Friction = field(default_factory=Friction)
    rotor: float = 0.0


@dataclass(frozen=True, eq=False)
class UncertainLink:
    """A link whose moments vary.

    Attributes:
        frame: its place in the body that it is part of.
        deviations: (8,) of `OF_LINKS`.
        first: the column of x that belongs to the first of them that is not zero.
    """

    inertial: Inertial
    frame: Frame
    deviations: Floats
    first: int

    @property
    def varied(self) -> list[int]:
        """The places in `OF_LINKS` of what varies."""
        return [int(k) for k in np.flatnonzero(self.deviations)]

    def added(self, x: Floats) -> Floats:
        """Return (draws, 10) what is added to the body's moments where what varies is off by x (draws, varied)."""
        off = np.zeros((1 + len(x), len(OF_LINKS)))
        off[1:, self.varied] = x * self.deviations[self.varied]
        (turn, c), mass = placement(self.inertial.origin), self.inertial.mass
        m = mass + off[:, 0]
        growth = (m / mass if mass else np.ones(len(m))) * (1.0 + off[:, 4])
        I_c = product(turn, symmetric(self.inertial.inertia), turn.T) * growth[:, None, None]
        I_c += off[:, 5:, None] * np.eye(3)
        _, R, p = self.frame
        centre = product(c + off[:, 1:4], R.T) + p
        squares = einsum("ni,ni->n", centre, centre)
        apart = squares[:, None, None] * np.eye(3) - centre[:, :, None] * centre[:, None, :]
        I = einsum("ij,njk,lk->nil", R, I_c, R) + m[:, None, None] * apart
        moments = np.column_stack((m, m[:, None] * centre, I[:, (0, 0, 0, 1, 1, 2), (0, 1, 2, 1, 2, 2)]))
        return np.asarray(moments[1:] - moments[0])


@dataclass(frozen=True, eq=False)
class Variations:
    """The uncertain parameters x of a robot, each of variance 1, and how they change theta, in which loads are linear.

    theta has the ten moments (`INERTIAL`) of each body that varies, and an entry of its own for each x at a joint.

    Attributes:
        each: in the order of the columns of x.
        links: those that vary otherwise than linearly.
        factor: L with x = L z for independent z; None where x is independent.
    """

    each: tuple[Variation, ...]
    links: tuple[UncertainLink, ...] = ()
    factor: Floats | None = None

    @cached_property
    def bodies(self) -> tuple[int, ...]:
        """The bodies that vary."""
        return tuple(sorted({variation.body for variation in self.each if variation.moments}))

    @cached_property
    def jacobian(self) -> Floats:
        """(m, k) the derivative of theta by x."""
        found = np.zeros(
            (len(self.bodies) * len(INERTIAL) + sum(not each.moments for each in self.each), len(self.each))
        )
        at = len(self.bodies) * len(INERTIAL)
        for k, variation in enumerate(self.each):
            if variation.moments:
                found[self._place(variation.body), k] = variation.moments
            else:
                found[at, k], at = 1.0, at + 1
        return found

    def along(self, changes: Floats) -> Floats:
        """Return derivatives by x (..., k) of what has these by theta (..., m)."""
        flat = changes.reshape(-1, len(self.jacobian))
        found = np.empty((len(flat), len(self.each)))
        for body in (*self.bodies, -1):
            columns = [k for k, variation in enumerate(self.each) if variation.body == body]
            rows = self._place(body)
            found[:, columns] = product(flat[:, rows], self.jacobian[rows][:, columns])
        return found.reshape(*changes.shape[:-1], len(self.each))

    def independent(self, changes: Floats) -> Floats:
        """Return derivatives by independent parameters of variance 1 (..., k) of what has these by theta (..., m)."""
        along = self.along(changes)
        if self.factor is None:
            return along
        return np.asarray(product(along.reshape(-1, len(self.each)), self.factor).reshape(along.shape))

    def spread(self, changes: Floats) -> Floats:
        """Return derivatives (..., p) by uncorrelated numbers that move theta as x does, to all orders.

        Their squares add up to the mean square of how what has the derivatives `changes` by theta (..., m) is off.
        """
        if not self.links:
            return self.independent(changes)
        return np.concatenate([product(changes[..., rows], root) for rows, root in self._roots], -1)

    @cached_property
    def _roots(self) -> list[tuple[slice, Floats]]:
        """The entries of theta of every body, and of joints, each with a root of their mean products."""
        drawn, found = self.theta(self.even_draws(_DRAWS, _SEED)), []
        for rows in [self._place(body) for body in (*self.bodies, -1)]:
            C = product(drawn[:, rows].T, drawn[:, rows]) / _DRAWS
            sizes = np.sqrt(np.diagonal(C))
            sizes = np.where(sizes > 0.0, sizes, 1.0)
            root = sizes[:, None] * pivoted(C / sizes / sizes[:, None])
            found.append((rows, root[:, root.any(0)]))
        return found

    def variance(self, changes: Floats) -> Floats:
        """Return the variance of what has these derivatives by theta (..., m), to first order."""
        along = self.independent(changes)
        return np.asarray(einsum("...k,...k->...", along, along))

    def theta(self, x: Floats) -> Floats:
        """Return (draws, m) by how much theta changes with x (draws, k), to all orders."""
        found = product(x, self.jacobian.T)
        for link in self.links:
            columns = slice(link.first, link.first + len(link.varied))
            place = self._place(link.frame.body)
            linear = product(x[:, columns], self.jacobian[place, columns].T)
            found[:, place] += link.added(x[:, columns]) - linear
        return np.asarray(found)

    def _place(self, body: int) -> slice:
        """Return where the moments of a body are in theta; of -1 what is at joints."""
        if body < 0:
            return slice(len(self.bodies) * len(INERTIAL), None)
        at = self.bodies.index(body) * len(INERTIAL)
        return slice(at, at + len(INERTIAL))

    def draws(self, count: int, seed: int) -> Floats:
        """Return (count, k) normal draws of x, the same for the same seed."""
        return self._correlated(np.random.default_rng(seed).standard_normal((count, len(self.each))))

    def even_draws(self, count: int, seed: int) -> Floats:
        """Return (count, k) draws of x, each independent parameter in even steps of probability (Latin hypercube)."""
        steps = np.array([NormalDist().inv_cdf((k + 0.5) / count) for k in range(count)])
        rng = np.random.default_rng(seed)
        return self._correlated(np.column_stack([rng.permutation(steps) for _ in self.each]))

    def _correlated(self, z: Floats) -> Floats:
        return z if self.factor is None else np.asarray(product(z, self.factor.T))

    @cached_property
    def correlation(self) -> Floats:
        """(k, k) of x."""
        return np.eye(len(self.each)) if self.factor is None else np.asarray(product(self.factor, self.factor.T))


def pivoted(C: Floats) -> Floats:
    """Return L (k, k) with L L^T = C, a correlation, by Cholesky's method with pivots; it ends where rounding is left.

    What an identification hardly tells apart has correlations near 1, and all that a torque shows of it is what these
    leave: 1e-13 of each variance is not nothing.
    """
    left, L = C.copy(), np.zeros_like(C)
    rounding = len(C) * np.finfo(float).eps
    for column in range(len(C)):
        k = int(np.diag(left).argmax())
        if left[k, k] <= rounding:
            break
        L[:, column] = left[:, k] / np.sqrt(left[k, k])
        left = left - np.outer(L[:, column], L[:, column])
    return L
