"""The dual scalar: a value with its rate of change, so that any recursion also yields the rates of its results."""

from __future__ import annotations

from typing import Any

from robodyn.programs.vectors import Scalar, cos, exp, sign, sin


class Dual:
    """x + x' eps with eps^2 = 0: forward differentiation along the motion. Both parts are any scalar."""

    __slots__ = ("rate", "value")

    def __init__(self, value: Scalar, rate: Scalar) -> None:
        self.value, self.rate = value, rate

    def __neg__(self) -> Dual:
        return Dual(-self.value, -self.rate)

    def __add__(self, other: Any) -> Dual:
        value, rate = _parts(other)
        return Dual(self.value + value, self.rate + rate)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Dual:
        value, rate = _parts(other)
        return Dual(self.value - value, self.rate - rate)

    def __rsub__(self, other: Any) -> Dual:
        return Dual(other, 0.0) - self

    def __mul__(self, other: Any) -> Dual:
        value, rate = _parts(other)
        return Dual(self.value * value, self.rate * value + self.value * rate)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Dual:
        value, rate = _parts(other)
        ratio = self.value / value
        return Dual(ratio, (self.rate - ratio * rate) / value)

    def __rtruediv__(self, other: Any) -> Dual:
        return Dual(other, 0.0) / self

    def sin(self) -> Dual:
        return Dual(sin(self.value), self.rate * cos(self.value))

    def cos(self) -> Dual:
        return Dual(cos(self.value), -(self.rate * sin(self.value)))

    def exp(self) -> Dual:
        value = exp(self.value)
        return Dual(value, self.rate * value)

    def sign(self) -> Dual:
        return Dual(sign(self.value), 0.0)


def _parts(x: Any) -> tuple[Scalar, Scalar]:
    return (x.value, x.rate) if isinstance(x, Dual) else (x, 0.0)


def value_of(x: Any) -> Scalar:
    """Return the value of a dual; anything else is its own value."""
    return _parts(x)[0]


def rate_of(x: Any) -> Scalar:
    """Return the rate of a dual; anything else is constant."""
    return _parts(x)[1]
