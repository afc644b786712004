"""Bodies of point masses, whose mass properties are sums of fractions and hold in floats without rounding."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from robodyn.solids.inertia.laws import exact
from robodyn.solids.inertia.properties import MassProperties


@dataclass(frozen=True)
class Cloud:
    """Masses (n,) and points (n, 3) as fractions."""

    masses: np.ndarray
    points: np.ndarray

    @property
    def mass(self):
        return self.masses.sum()

    @property
    def com(self):
        return self.masses @ self.points / self.mass

    def second(self, point):
        """The integral of (x - point)(x - point)^T dm."""
        arms = self.points - point
        return arms.T @ (self.masses[:, None] * arms)

    def inertia(self, point):
        """The integral of |x - point|^2 1 - (x - point)(x - point)^T dm, term by term."""
        total = exact(np.zeros((3, 3)))
        for mass, arm in zip(self.masses, self.points - point, strict=True):
            total = total + mass * ((arm @ arm) * exact(np.eye(3)) - np.outer(arm, arm))
        return total

    def placed(self, R, p):
        return Cloud(self.masses, self.points @ exact(R).T + exact(p))

    @property
    def properties(self):
        return MassProperties(self.mass, self.com, self.second(self.com))


def joined(*clouds):
    return Cloud(np.concatenate([c.masses for c in clouds]), np.concatenate([c.points for c in clouds]))


def random_cloud(seed, points=6, size=(1.0, 1.0, 1.0)):
    """Points on a lattice of 1/1024 of each size; masses that add up to 64, so that the centre is a float too."""
    rng = np.random.default_rng(seed)
    masses = rng.integers(1, 9, points)
    masses[-1] = 64 - masses[:-1].sum()
    lattice = rng.integers(-1024, 1025, (points, 3)) / 1024
    return Cloud(np.array([Fraction(int(m)) for m in masses], dtype=object), exact(lattice * size))


def floats(fractions):
    return np.asarray(fractions).astype(float)


def within(found, expected, relative):
    """Whether each of the fractions found lies within this part of the one expected; exactly, without rounding."""
    return all(abs(f - e) <= Fraction(relative) * abs(e) for f, e in zip(found.flat, expected.flat, strict=True))
