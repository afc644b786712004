"""A program as one LLVM function: a loop over groups of samples, the whole program in its body."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from typing import Any

from robodyn.programs.program import Program
from robodyn.programs.run.llvm.functions import (
    BYTES,
    LARGEST_QUARTER,
    Code,
    exponential,
    reduced,
    sign,
    sine_and_cosine,
)
from robodyn.programs.scalar import ADD, CONSTANT, COS, DIV, EXP, INPUT, MUL, NEG, SIGN, SIN, SQRT, SUB


def fused_products(program: Program) -> dict[int, int]:
    """For each sum or difference that takes in a product: the position of that product.

    A product is taken in where every use of it is a sum that has not yet taken in another: then it is never formed on
    its own. Products used once come first, for they cost nothing twice. The choice depends on the program alone, so
    every processor rounds alike.
    """
    users: dict[int, list[int]] = defaultdict(list)
    for k, (op, a, b) in enumerate(program.operations):
        if op is not INPUT and op is not CONSTANT:
            users[a].append(k)
            if b is not None:
                users[b].append(k)
    outputs = set(program.outputs)
    products = [k for k, (op, _, _) in enumerate(program.operations) if op is MUL and k not in outputs]
    taken: dict[int, int] = {}
    for product in sorted(products, key=lambda k: len(users[k])):
        sums = users[product]
        fitting = all(program.operations[k][0] in (ADD, SUB) and k not in taken for k in sums)
        if fitting and len(set(sums)) == len(sums):
            taken.update(dict.fromkeys(sums, product))
    return taken


TWO = {ADD: "fadd", SUB: "fsub", MUL: "fmul", DIV: "fdiv"}
ONE: dict[str, Callable[[Code, str], str]] = {
    NEG: Code.neg,
    SQRT: lambda code, x: code.call("sqrt", x),
    EXP: exponential,
    SIGN: sign,
}

PART = 500
"""Instructions in a basic block: LLVM's time grows faster than a block's length, and the code is no better for it."""
LEVEL = 2
"""How near memory is brought, from 3 for the first cache down: what comes ahead would displace what is in use."""
FRAME = """\
declare void @llvm.prefetch.p0(ptr, i32, i32, i32)
{declared}
define i64 @kernel(ptr noalias readonly %rows, ptr noalias writeonly %flags, i64 %groups) #0 {{
entry:
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %end ]
  %any = phi i64 [ 0, %entry ], [ %some, %end ]
  %o = mul i64 %i, {lanes}
{body}
  br label %end
end:
  %next = add i64 %i, 1
  %more = icmp ult i64 %next, %groups
  br i1 %more, label %loop, label %done
done:
  ret i64 %some
}}
attributes #0 = {{ nounwind "stackrealign" "prefer-vector-width"="512" "min-legal-vector-width"="512" }}
!0 = !{{}}
"""


def kernel(program: Program, first_row: Mapping[str, int], scalar: str, lanes: int, calls: bool = True) -> str:
    """Return the LLVM IR of `i64 kernel(rows, flags, groups)`.

    `rows` points to an array of pointers: to the columns of the inputs, then to those of the outputs, each a column of
    `groups * lanes` numbers. No output may overlap an input. If the kernel calls for memory, every pointer is followed
    by another, to a column of as many numbers that will be wanted next; it need not exist. Bit k of the flags of group
    i is set where an angle of its sample k is too large to be reduced accurately, or is not finite; the function
    returns 0 where no flag is set.

    Args:
        first_row: where in `rows` the columns of each source begin, and under "" those of the outputs.
        lanes: samples in a group: 8 or 16.
        calls: for the memory that will be wanted next, a line of the cache for every vector that is moved.
    """
    writer = Writer(program, first_row, Code(scalar, lanes), fused_products(program), calls)
    writer.write()
    writer.flag()
    return FRAME.format(
        declared="\n".join(sorted(writer.code.declared)), lanes=lanes, body="\n".join(writer.code.lines)
    )


class Writer:
    """Writes the body of the loop; an operand is the register that holds it, or a constant."""

    def __init__(
        self, program: Program, first_row: Mapping[str, int], code: Code, fused: Mapping[int, int], calls: bool
    ) -> None:
        self.program, self.first_row, self.code, self.fused, self.calls = program, first_row, code, fused, calls
        self.values: list[str] = []
        self.angles: dict[int, tuple[str, str]] = {}
        self.quarters: list[str] = []
        self.parts = 0

    def write(self) -> None:
        program = self.program
        homes: dict[int, list[int]] = defaultdict(list)
        for place, position in enumerate(program.outputs):
            homes[position].append(self.first_row[""] + place)
        products = set(self.fused.values())
        for k, (op, a, b) in enumerate(program.operations):
            self.values.append("" if k in products else self._value(k, op, a, b))
            for row in homes[k]:
                self._store(self.values[k], row)
                self._divide()
            self._divide()

    def _store(self, value: str, row: int) -> None:
        address = self._address(row, 1)
        self.code.do(f"store {self.code.vector} {value}, ptr {address}, align {BYTES[self.code.scalar]}")

    def _divide(self) -> None:
        """Begins a basic block where the last one is long enough."""
        lines = self.code.lines
        if len(lines) > PART * (self.parts + 1):
            self.parts += 1
            lines.append(f"  br label %part{self.parts}\npart{self.parts}:")

    def _address(self, row: int, writes: int) -> str:
        """Return where a column's numbers of this group lie; those that will be wanted are called for."""
        if not self.calls:
            return self._place(row)
        ahead = self._place(2 * row + 1)
        self.code.do(f"call void @llvm.prefetch.p0(ptr {ahead}, i32 {writes}, i32 {LEVEL}, i32 1)")
        return self._place(2 * row)

    def _place(self, entry: int) -> str:
        """Return where this group's numbers lie in the column of an entry of `rows`."""
        place = self.code.new(f"getelementptr ptr, ptr %rows, i64 {entry}")
        column = self.code.new(f"load ptr, ptr {place}, align 8, !invariant.load !0")
        return self.code.new(f"getelementptr {self.code.scalar}, ptr {column}, i64 %o")

    def _input(self, source: str, column: int) -> str:
        address, align = self._address(self.first_row[source] + column, 0), BYTES[self.code.scalar]
        return self.code.new(f"load {self.code.vector}, ptr {address}, align {align}, !invariant.load !0")

    def _value(self, k: int, op: str, a: Any, b: Any) -> str:
        code = self.code
        if op is INPUT:
            return self._input(a, b)
        if op is CONSTANT:
            return code.constant(a)
        if k in self.fused:
            return self._sum(op, a, b, self.fused[k])
        if op is SIN or op is COS:
            return self._angle(a)[op is COS]
        if op in TWO:
            return code.two(TWO[op], self.values[a], self.values[b])
        return ONE[op](code, self.values[a])

    def _sum(self, op: str, a: int, b: int, product: int) -> str:
        """x y + z, x y - z or z - x y."""
        code = self.code
        _, i, j = self.program.operations[product]
        x, y = self.values[i], self.values[j]
        if a == product:
            z = self.values[b]
            return code.fma(x, y, z if op is ADD else code.neg(z))
        return code.fma(x if op is ADD else code.neg(x), y, self.values[a])

    def _angle(self, argument: int) -> tuple[str, str]:
        if argument not in self.angles:
            angle = reduced(self.code, self.values[argument])
            self.quarters.append(angle.quarters)
            self.angles[argument] = sine_and_cosine(self.code, angle)
        return self.angles[argument]

    def too_large(self) -> str:
        """A bit per sample: the sum of the squares of all quarter turns exceeds that of the largest, or is NaN."""
        code, wide = self.code, self.code.doubles()
        if not self.quarters:
            return "0"
        total = wide.two("fmul", self.quarters[0], self.quarters[0])
        for quarters in self.quarters[1:]:
            total = wide.fma(quarters, quarters, total)
        mask = wide.compare("ugt", total, wide.constant(LARGEST_QUARTER**2))
        return code.new(f"bitcast {code.mask} {mask} to i{code.lanes}")

    def flag(self) -> None:
        code, flags = self.code, self.too_large()
        if self.quarters:
            address = code.new(f"getelementptr i{code.lanes}, ptr %flags, i64 %i")
            code.do(f"store i{code.lanes} {flags}, ptr {address}, align 1")
        code.lines.append(f"  %whole = zext i{code.lanes} {flags} to i64\n  %some = or i64 %any, %whole")
