"""Value, first and second rate of quantities that depend on time, by the rules of differentiation: no step is chosen.

A number is a quantity that does not change.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

Number = Any
"""A float or an array of floats."""


@dataclass(frozen=True, eq=False)
class Jet:
    """x, x' and x''."""

    x: Number
    v: Number = 0
    a: Number = 0

    __array_ufunc__ = None  # an array to the left leaves the operation to the jet

    def __add__(self, other: Jet | Number) -> Jet:
        y = jet(other)
        return Jet(self.x + y.x, self.v + y.v, self.a + y.a)

    def __mul__(self, other: Jet | Number) -> Jet:
        y = jet(other)
        return Jet(
            self.x * y.x,
            self.v * y.x + self.x * y.v,
            self.a * y.x + 2 * self.v * y.v + self.x * y.a,
        )

    def __truediv__(self, other: Jet | Number) -> Jet:
        y = jet(other)
        x = self.x / y.x
        v = (self.v - x * y.v) / y.x
        return Jet(x, v, (self.a - 2 * v * y.v - x * y.a) / y.x)

    def __neg__(self) -> Jet:
        return Jet(-self.x, -self.v, -self.a)

    def __sub__(self, other: Jet | Number) -> Jet:
        return self + -jet(other)

    def __rsub__(self, other: Jet | Number) -> Jet:
        return jet(other) - self

    def __rtruediv__(self, other: Jet | Number) -> Jet:
        return jet(other) / self

    __radd__ = __add__
    __rmul__ = __mul__


Pair = tuple[Jet, Jet]
Triple = tuple[Jet, Jet, Jet]


def jet(value: Jet | Number) -> Jet:
    return value if isinstance(value, Jet) else Jet(value)


def sin(u: Jet) -> Jet:
    s, c = np.sin(u.x), np.cos(u.x)
    return Jet(s, c * u.v, c * u.a - s * u.v * u.v)


def cos(u: Jet) -> Jet:
    s, c = np.sin(u.x), np.cos(u.x)
    return Jet(c, -s * u.v, -s * u.a - c * u.v * u.v)


def sqrt(u: Jet) -> Jet:
    x = np.sqrt(u.x)
    v = u.v / (2 * x)
    return Jet(x, v, (u.a - 2 * v * v) / (2 * x))


def atan2(y: Jet | Number, x: Jet | Number) -> Jet:
    """The angle of (x, y): with r^2 = x^2 + y^2 its rate is (x y' - y x') / r^2."""
    y, x = jet(y), jet(x)
    turn = Jet(x.x * y.v - y.x * x.v, x.x * y.a - y.x * x.a)
    rate = turn / Jet(x.x * x.x + y.x * y.x, 2 * (x.x * x.v + y.x * y.v))
    return Jet(np.arctan2(y.x, x.x), rate.x, rate.v)


def acos(c: Jet) -> Jet:
    return atan2(sqrt(1 - c * c), c)


def dot(a: tuple[Jet, ...], b: tuple[Jet, ...]) -> Jet:
    found = jet(0)
    for x, y in zip(a, b, strict=True):
        found = found + x * y
    return found


def rotated(angle: Jet | Number, p: tuple[Jet | Number, Jet | Number]) -> Pair:
    """Return a vector of the plane, turned."""
    c, s = cos(jet(angle)), sin(jet(angle))
    return c * p[0] - s * p[1], s * p[0] + c * p[1]
