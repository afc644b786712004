"""Lines of LLVM IR on vectors of one floating-point type; sine, cosine, exponential and sign as such lines.

The polynomials are minimax on the reduced range (Remez exchange at 60 digits). With rounded coefficients their error is
below 2^-56 of the function there, and in single precision below 2^-27.
"""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import count
from typing import NamedTuple

SUFFIXES = {"double": "f64", "float": "f32"}
BYTES = {"double": 8, "float": 4}
LARGEST_QUARTER = 2.0**20
"""Quarter turns up to which the reduction of an angle is accurate: 1.6e6 rad."""


@dataclass
class Code:
    """The body of a function that works on `lanes` samples at a time, a power of two, in "double" or "float". Operands
    are the text that names them in IR: a register or a constant. `pooled`: constants are vectors in memory."""

    scalar: str
    lanes: int
    pooled: bool = False
    lines: list[str] = field(default_factory=list)
    declared: set[str] = field(default_factory=set)
    numbers: Iterator[int] = field(default_factory=count)

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
        name = f"%v{next(self.numbers)}"
        self.lines.append(f"  {name} = {instruction}")
        return name

    def do(self, instruction: str) -> None:
        self.lines.append(f"  {instruction}")

    def constant(self, value: float, again: bool = False) -> str:
        """Return the same number in every lane, rounded to the scalar type; `again`: read it anew, under a name of its
        own, where LLVM would keep it in a register from one use to the next."""
        if self.scalar == "float":
            value = ctypes.c_float(value).value
        digits = f"{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"
        if not self.pooled:
            return f"splat ({self.scalar} 0x{digits})"
        name = f"@{self.scalar}{digits}"
        self.declared.add(f"{name} = private constant {self.vector} splat ({self.scalar} 0x{digits})")
        if again:
            name, first = f"{name}.{next(self.numbers)}", name
            self.declared.add(f"{name} = private alias {self.vector}, ptr {first}")
        return self.new(f"load {self.vector}, ptr {name}, align {self.lanes * BYTES[self.scalar]}, !invariant.load !0")

    def integer(self, value: int) -> str:
        return f"splat (i{8 * BYTES[self.scalar]} {value})"

    def bits_of(self, value: float) -> str:
        return self.integer(struct.unpack("<q", struct.pack("<d", value))[0])

    def two(self, instruction: str, a: str, b: str) -> str:
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
        return self.call("fma", a, b, c)

    def horner(self, coefficients: tuple[float, ...], x: str) -> str:
        """c0 + c1 x + c2 x^2 + ..."""
        value = self.constant(coefficients[-1], again=True)
        for coefficient in coefficients[-2::-1]:
            value = self.fma(value, x, self.constant(coefficient, again=True))
        return value

    def select(self, mask: str, a: str, b: str) -> str:
        return self.new(f"select {self.mask} {mask}, {self.vector} {a}, {self.vector} {b}")

    def compare(self, predicate: str, a: str, b: str) -> str:
        return self.new(f"fcmp {predicate} {self.vector} {a}, {b}")

    def whole(self, instruction: str, a: str, b: str) -> str:
        """Return the register of an instruction on integers: and, xor, add, shl, ashr."""
        return self.new(f"{instruction} {self.integers} {a}, {b}")

    def bits(self, a: str) -> str:
        return self.new(f"bitcast {self.vector} {a} to {self.integers}")

    def number(self, a: str) -> str:
        return self.new(f"bitcast {self.integers} {a} to {self.vector}")

    def convert(self, a: str, to: Code) -> str:
        """Return the same numbers in the scalar type of `to`, which shares the lines of this code."""
        instruction = "fpext" if BYTES[to.scalar] > BYTES[self.scalar] else "fptrunc"
        return self.new(f"{instruction} {self.vector} {a} to {to.vector}")

    def doubles(self) -> Code:
        return replace(self, scalar="double")


def _hex(text: str) -> tuple[float, ...]:
    return tuple(map(float.fromhex, text.split()))


HALF_PI = _hex("0x1.921fb54442d18p+0 0x1.1a626331p-54 0x1.1701b839a2520p-88")
"""pi/2 in three parts, the second of 33 bits so that its product with 20 bits is exact."""
TWO_BY_PI = float.fromhex("0x1.45f306dc9c883p-1")
LOG_2 = _hex("0x1.62e42feep-1 0x1.a39ef35793c76p-33")
LOG2_E = float.fromhex("0x1.71547652b82fep+0")
ROUNDING = 1.5 * 2.0**52
"""The sum of this and a number is that number's nearest integer in its low bits."""

# (sin x - x) / x^3 and (cos x - 1 + x^2/2) / x^4 in powers of x^2, for |x| <= pi/4.
SINE = {
    "double": _hex(
        "-0x1.5555555555549p-3 0x1.111111110f881p-7 -0x1.a01a019c126bbp-13"
        " 0x1.71de357873863p-19 -0x1.ae5e66d3905f9p-26 0x1.5d932ec592646p-33"
    ),
    "float": _hex("-0x1.555545994fa3ep-3 0x1.1107604fdfbffp-7 -0x1.994eb2e1104b9p-13"),
}
COSINE = {
    "double": _hex(
        "0x1.555555555554cp-5 -0x1.6c16c16c15184p-10 0x1.a01a019cb2715p-16"
        " -0x1.27e4f80a77c06p-22 0x1.1ee9ec487168cp-29 -0x1.8faecf783200bp-37"
    ),
    "float": _hex("0x1.55554ab44c364p-5 -0x1.6c0c8be3a879ep-10 0x1.9a0264b568566p-16"),
}
# (exp x - 1 - x) / x^2 in powers of x, for |x| <= log(2)/2.
EXPONENTIAL = _hex(
    "0x1.000000000000bp-1 0x1.5555555555561p-3 0x1.5555555550042p-5 0x1.111111110d626p-7 0x1.6c16c185a3634p-10"
    " 0x1.a01a01bae8f42p-13 0x1.a019969e9a720p-16 0x1.71dddfbe2f304p-19 0x1.28b03ed71fefep-22 0x1.af859ad55f9d0p-26"
)


class Angle(NamedTuple):
    """x = quarters pi/2 + high + low, |high| <= pi/4, low mostly less than an ulp of high; quarters are in double
    precision; integer: integers whose low bits are the quarters', as wide as the scalar."""

    quarters: str
    integer: str
    high: str
    low: str


def reduced(code: Code, x: str) -> Angle:
    """Return an angle brought to the first eighth of a turn, in double precision whatever its own.

    Method: Cody and Waite, "Software Manual for the Elementary Functions" (1980), ch. 8, with fused multiply-add: what
    is left of the angle without the first part of pi/2 is exact, and so is what subtracting the second part loses, for
    that rest is a multiple of the product's last place (Dekker's fast two-sum). So an angle next to a multiple of pi/2
    leaves as many digits as any other.
    """
    wide = code.doubles()
    angle = x if code.scalar == "double" else code.convert(x, wide)
    shifted = wide.fma(angle, wide.constant(TWO_BY_PI), wide.constant(ROUNDING))
    quarters = wide.two("fsub", shifted, wide.constant(ROUNDING))
    first, second, third = (wide.constant(-part) for part in HALF_PI)
    rest = wide.fma(quarters, first, angle)
    high = wide.fma(quarters, second, rest)
    integer = wide.bits(shifted)
    if code.scalar == "float":
        narrow = wide.convert(high, code)
        lost = wide.two("fsub", high, code.convert(narrow, wide))
        low_bits = code.new(f"trunc {wide.integers} {integer} to {code.integers}")
        return Angle(quarters, low_bits, narrow, wide.convert(lost, code))
    low = wide.fma(quarters, second, wide.two("fsub", rest, high))
    return Angle(quarters, integer, high, wide.fma(quarters, third, low))


def sine_and_cosine(code: Code, angle: Angle) -> tuple[str, str]:
    """sin x and cos x. Accuracy: 0.9 ulp for at most `LARGEST_QUARTER` quarter turns; sin(-0) is 0."""
    x, low = angle.high, angle.low
    square = code.two("fmul", x, x)
    cube = code.two("fmul", square, x)
    tail = code.horner(SINE[code.scalar], square)
    sine = code.two("fadd", x, code.fma(cube, tail, low))

    half, one = code.constant(-0.5), code.constant(1.0)
    main = code.fma(square, half, one)
    rest = code.fma(square, half, code.two("fsub", one, main))
    rest = code.fma(code.two("fmul", square, square), code.horner(COSINE[code.scalar], square), rest)
    cosine = code.two("fadd", main, code.fma(code.neg(x), low, rest))

    odd = code.new(f"trunc {code.integers} {angle.integer} to {code.mask}")
    next_quarter = code.whole("add", angle.integer, code.integer(1))
    return (
        _with_sign(code, code.select(odd, cosine, sine), angle.integer),
        _with_sign(code, code.select(odd, sine, cosine), next_quarter),
    )


def _with_sign(code: Code, value: str, quarter: str) -> str:
    """Return a value whose sign flips in the third and fourth quarter: where bit 1 of `quarter` is set."""
    top = 63 if code.scalar == "double" else 31
    flip = code.whole("and", code.whole("shl", quarter, code.integer(top - 1)), code.integer(-(1 << top)))
    return code.number(code.whole("xor", code.bits(value), flip))


def exponential(code: Code, x: str) -> str:
    """exp x, computed in double precision. Accuracy: 0.9 ulp; 0 and infinity where the result leaves the range of the
    type."""
    wide = code.doubles()
    y = x if code.scalar == "double" else code.convert(x, wide)
    for predicate, limit in (("olt", -746.0), ("ogt", 710.0)):
        y = wide.select(wide.compare(predicate, y, wide.constant(limit)), wide.constant(limit), y)
    shifted = wide.fma(y, wide.constant(LOG2_E), wide.constant(ROUNDING))
    power = wide.two("fsub", shifted, wide.constant(ROUNDING))
    rest = wide.fma(power, wide.constant(-LOG_2[1]), wide.fma(power, wide.constant(-LOG_2[0]), y))
    bend = wide.horner(EXPONENTIAL, rest)
    one = wide.constant(1.0)
    main = wide.two("fadd", one, rest)
    lost = wide.two("fadd", wide.two("fsub", one, main), rest)
    value = wide.two("fadd", main, wide.fma(wide.two("fmul", rest, rest), bend, lost))
    # 2^power in two factors, for it may leave the range of normal numbers where the product does not.
    integer = wide.whole("sub", wide.bits(shifted), wide.bits_of(ROUNDING))
    half = wide.whole("ashr", integer, wide.integer(1))
    for part in (half, wide.whole("sub", integer, half)):
        exponent = wide.whole("shl", wide.whole("add", part, wide.integer(1023)), wide.integer(52))
        value = wide.two("fmul", value, wide.number(exponent))
    return value if code.scalar == "double" else wide.convert(value, code)


def sign(code: Code, x: str) -> str:
    """-1, 0 or 1; NaN of NaN."""
    zero = code.constant(0.0)
    still = code.two("fmul", x, zero)
    falling = code.select(code.compare("olt", x, zero), code.constant(-1.0), still)
    return code.select(code.compare("ogt", x, zero), code.constant(1.0), falling)
