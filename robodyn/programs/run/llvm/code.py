"""Lines of LLVM IR: instructions on vectors of one floating-point type, each with a name of its own."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

SUFFIXES = {"double": "f64", "float": "f32"}
BYTES = {"double": 8, "float": 4}


@dataclass
class Code:
    """The body of a function that works on `lanes` samples at a time.

    Operands are the text that names them in IR: a register or a constant.

    Attributes:
        scalar: "double" or "float".
        lanes: numbers in a vector; a power of two.
        lines: the instructions written so far.
        declared: declarations of the intrinsics that they call.
    """

    scalar: str
    lanes: int
    lines: list[str] = field(default_factory=list)
    declared: set[str] = field(default_factory=set)

    @property
    def vector(self) -> str:
        return f"<{self.lanes} x {self.scalar}>"

    @property
    def integers(self) -> str:
        return f"<{self.lanes} x i{8 * BYTES[self.scalar]}>"

    @property
    def mask(self) -> str:
        return f"<{self.lanes} x i1>"

    def new(self, instruction: str) -> str:
        """Return the register that holds the result of an instruction."""
        name = f"%v{len(self.lines)}"
        self.lines.append(f"  {name} = {instruction}")
        return name

    def do(self, instruction: str) -> None:
        """An instruction without a result."""
        self.lines.append(f"  {instruction}")

    def constant(self, value: float) -> str:
        """Return the same number in every lane, rounded to the scalar type."""
        if self.scalar == "float":
            value = _as_float32(value)
        return f"splat ({self.scalar} 0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X})"

    def integer(self, value: int) -> str:
        """Return the same integer, as wide as the scalar, in every lane."""
        return f"splat (i{8 * BYTES[self.scalar]} {value})"

    def bits_of(self, value: float) -> str:
        """Return the bits of a double, as an integer in every lane."""
        return self.integer(struct.unpack("<q", struct.pack("<d", value))[0])

    def two(self, instruction: str, a: str, b: str) -> str:
        """fadd, fsub, fmul or fdiv."""
        return self.new(f"{instruction} {self.vector} {a}, {b}")

    def neg(self, a: str) -> str:
        return self.new(f"fneg {self.vector} {a}")

    def call(self, intrinsic: str, *arguments: str) -> str:
        """Return the register of an intrinsic that maps vectors of this type to one, such as `sqrt`."""
        name = f"@llvm.{intrinsic}.v{self.lanes}{SUFFIXES[self.scalar]}"
        types = ", ".join(self.vector for _ in arguments)
        self.declared.add(f"declare {self.vector} {name}({types})")
        return self.new(f"call {self.vector} {name}({', '.join(f'{self.vector} {x}' for x in arguments)})")

    def fma(self, a: str, b: str, c: str) -> str:
        """a b + c with one rounding."""
        return self.call("fma", a, b, c)

    def horner(self, coefficients: tuple[float, ...], x: str) -> str:
        """c0 + c1 x + c2 x^2 + ..."""
        value = self.constant(coefficients[-1])
        for coefficient in coefficients[-2::-1]:
            value = self.fma(value, x, self.constant(coefficient))
        return value

    def select(self, mask: str, a: str, b: str) -> str:
        return self.new(f"select {self.mask} {mask}, {self.vector} {a}, {self.vector} {b}")

    def compare(self, predicate: str, a: str, b: str) -> str:
        return self.new(f"fcmp {predicate} {self.vector} {a}, {b}")

    def whole(self, instruction: str, a: str, b: str) -> str:
        """Return the register of an instruction on integers: and, xor, add, shl, ashr."""
        return self.new(f"{instruction} {self.integers} {a}, {b}")

    def bits(self, a: str) -> str:
        """Return the bits of a vector of numbers, as integers."""
        return self.new(f"bitcast {self.vector} {a} to {self.integers}")

    def number(self, a: str) -> str:
        """Return the numbers whose bits these integers are."""
        return self.new(f"bitcast {self.integers} {a} to {self.vector}")

    def convert(self, a: str, to: Code) -> str:
        """Return the same numbers in the scalar type of `to`, which shares the lines of this code."""
        instruction = "fpext" if BYTES[to.scalar] > BYTES[self.scalar] else "fptrunc"
        return self.new(f"{instruction} {self.vector} {a} to {to.vector}")

    def doubles(self) -> Code:
        """Code that writes double precision among these lines."""
        return Code("double", self.lanes, self.lines, self.declared)


def _as_float32(value: float) -> float:
    try:
        return float(struct.unpack("<f", struct.pack("<f", value))[0])
    except OverflowError:
        return float("inf") if value > 0 else float("-inf")
