"""The traced scalar: arithmetic that writes itself down.

Running a recursion on traced scalars records every operation once (hash-consing) and never records what is known
beforehand: a sum with 0, a product with 0, 1 or -1, a difference of a thing and itself. Only rules that leave every
finite result unchanged to the last bit are used, up to the sign of a zero. Constants stay plain Python floats, so an
expression that folds to a constant leaves the trace.
"""

from __future__ import annotations

from typing import Any

NEG, ADD, SUB, MUL, DIV = "neg", "add", "sub", "mul", "div"
SQRT, SIN, COS, SIGN, EXP = "sqrt", "sin", "cos", "sign", "exp"
INPUT, CONSTANT = "input", "constant"


class Tape:
    """Where the operations of one trace are written: every distinct (operation, arguments) exactly once, in order."""

    def __init__(self) -> None:
        self.nodes: dict[tuple[str, Any, Any], Traced] = {}

    def input(self, source: str, index: int) -> Traced:
        """Return the scalar that stands for column `index` of the array named `source`."""
        return self.node(INPUT, source, index)

    def constant(self, value: float) -> Traced:
        return self.node(CONSTANT, float(value), None)

    def node(self, op: str, a: Any, b: Any) -> Traced:
        new = Traced()
        known = self.nodes.setdefault((op, a, b), new)  # most are new: one search finds that out and puts them there
        if known is new:
            new.tape, new.op, new.a, new.b, new.serial = self, op, a, b, len(self.nodes) - 1
        return known


class Traced:
    """A scalar known only when the program runs: an input, or an operation on other traced scalars; the tape's node of
    number `serial`."""

    __slots__ = ("a", "b", "op", "serial", "tape")
    tape: Tape
    op: str
    a: Any
    b: Any
    serial: int

    def __repr__(self) -> str:
        return f"<{self.op} #{self.serial}>"

    def __neg__(self) -> Traced:
        if self.op is NEG:
            return self.a  # type: ignore[no-any-return]
        if self.op is SUB:
            return self.tape.node(SUB, self.b, self.a)
        return self.tape.node(NEG, self, None)

    def __add__(self, other: Any) -> Any:
        if other.__class__ is not Traced:
            if other == 0.0:
                return self
            other = self.tape.constant(other)
        if other.op is NEG:
            return self - other.a
        if self.op is NEG:
            return other - self.a
        first, second = (self, other) if self.serial <= other.serial else (other, self)
        return self.tape.node(ADD, first, second)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        if other.__class__ is not Traced:
            if other == 0.0:
                return self
            other = self.tape.constant(other)
        if other is self:
            return 0.0
        if other.op is NEG:
            return self + other.a
        if self.op is NEG:
            return -(self.a + other)
        return self.tape.node(SUB, self, other)

    def __rsub__(self, other: Any) -> Any:
        return (-self) + other

    def __mul__(self, other: Any) -> Any:
        if other.__class__ is not Traced:
            if other == 0.0:
                return 0.0
            if other == 1.0:
                return self
            if other < 0.0:
                return -(self * -other)
            other = self.tape.constant(other)
        if self.op is NEG:
            return -(self.a * other)
        if other.op is NEG:
            return -(self * other.a)
        first, second = (self, other) if self.serial <= other.serial else (other, self)
        return self.tape.node(MUL, first, second)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        if other.__class__ is not Traced:
            if other == 1.0:
                return self
            if other < 0.0:
                return -(self / -other)
            other = self.tape.constant(other)
        if self.op is NEG:
            return -(self.a / other)
        if other.op is NEG:
            return -(self / other.a)
        return self.tape.node(DIV, self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return 0.0 if other == 0.0 else self.tape.constant(other) / self

    def sqrt(self) -> Traced:
        return self.tape.node(SQRT, self, None)

    def exp(self) -> Traced:
        return self.tape.node(EXP, self, None)

    def cos(self) -> Traced:
        return self.tape.node(COS, self.a if self.op is NEG else self, None)

    def sin(self) -> Traced:
        return -self.tape.node(SIN, self.a, None) if self.op is NEG else self.tape.node(SIN, self, None)

    def sign(self) -> Traced:
        return -self.tape.node(SIGN, self.a, None) if self.op is NEG else self.tape.node(SIGN, self, None)
