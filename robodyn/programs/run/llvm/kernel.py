"""A program as one LLVM function: a loop over groups of samples, the whole program in its body."""

from __future__ import annotations

import re
import sys
from bisect import bisect
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from itertools import count
from typing import Any

import numpy as np

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

BLOCK = {True: 800, False: 500}
"""Instructions in a basic block, with pooled constants and without: in longer ones LLVM's time and the values that it
puts by grow faster than length, its time more so where there are more registers."""
LATENCY = 4
"""Cycles from the begin of an arithmetic instruction to its result."""
REGISTER = re.compile(r"%v\d+")
PART = 2400
"""Operations in a part of a program at most: a processor keeps so many decoded, and others it decodes ever anew."""
GROUPS = 32
"""Groups that a part works on before the next part begins, if what they keep for later parts is not too much."""
KEPT = 1 << 17
"""Bytes that they may keep, which stay in a core's own caches."""
AHEAD = 256
"""Bytes from the numbers in use to those of the same column that are called for."""
LEVEL = 2
"""How near memory is brought, from 3 for the first cache down: what comes ahead would displace what is in use."""
ANGLE = 20
"""Operations that a sine or a cosine stands for."""
FEWEST = 4
"""Groups that are worth parts."""
TOTAL = -1
"""Stands for the sum of squares of all quarter turns among the positions of values."""
FRAME = """\
declare void @llvm.prefetch.p0(ptr, i32, i32, i32)
declare i64 @llvm.umin.i64(i64, i64)
{declared}
define i64 @kernel(ptr noalias readonly %rows, ptr noalias writeonly %flags, i64 %groups) #0 {{
entry:
  %kept = alloca [{kept} x i8], align 64
  %some = alloca i64
  store i64 0, ptr %some
  br label %loop
loop:
  %first = phi i64 [ 0, %entry ], [ %next, %end ]
  %left = sub i64 %groups, %first
  %count = call i64 @llvm.umin.i64(i64 %left, i64 {count})
  br label %loop0
{body}
end:
  %next = add i64 %first, {count}
  %more = icmp ult i64 %next, %groups
  br i1 %more, label %loop, label %done
done:
  %flagged = load i64, ptr %some
  ret i64 %flagged
}}
attributes #0 = {{ nounwind "stackrealign" "prefer-vector-width"="512" "min-legal-vector-width"="512" }}
!0 = !{{}}
"""
LOOP = """\
loop{p}:
  %g{p} = phi i64 [ 0, %{before} ], [ %next{p}, %end{p} ]
  %base{p} = phi ptr [ %kept, %{before} ], [ %further{p}, %end{p} ]
  %i{p} = add i64 %first, %g{p}
  %offset{p} = mul i64 %i{p}, {lanes}"""
END = """\
  br label %end{p}
end{p}:
  %next{p} = add i64 %g{p}, 1
  %further{p} = getelementptr i8, ptr %base{p}, i64 {bytes}
  %more{p} = icmp ult i64 %next{p}, %count
  br i1 %more{p}, label %loop{p}, label %{then}"""


def kernel(
    program: Program, first_row: Mapping[str, int], scalar: str, lanes: int, calls: bool = True, pooled: bool = False
) -> str:
    """Return the LLVM IR of `i64 kernel(rows, flags, groups)`.

    `rows` points to an array of pointers: to the columns of the inputs, then to those of the outputs, each a column of
    `groups * lanes` numbers. No output may overlap an input. Bit k of the flags of group i, of 8 bits or as many as
    there are lanes, is set where an angle of its sample k is too large to be reduced accurately, or is not finite; the
    function returns 0 where no flag is set.

    A long program is cut into parts where few values are alive. Each works on some groups before the next begins, so
    that its instructions stay decoded; what later parts read of a group is kept in memory.

    Args:
        first_row: where in `rows` the columns of each source begin, and under "" those of the outputs.
        lanes: samples in a group, a power of two up to 16.
        calls: for the numbers of a column that will be wanted soon, also beyond its end, which need not exist.
        pooled: constants are whole vectors in memory, which instructions take as operands.
    """
    writer = _Parts(program, first_row, Code(scalar, lanes, pooled), fused_products(program), calls)
    writer.write()
    names = {"kept": writer.count * writer.group, "count": writer.count, "body": "\n".join(writer.code.lines)}
    return FRAME.format(declared="\n".join(sorted(writer.code.declared)), **names)


class Writer:
    """Writes operations one after another; an operand is the register that holds it, or a constant."""

    def __init__(
        self, program: Program, first_row: Mapping[str, int], code: Code, fused: Mapping[int, int], calls: bool
    ) -> None:
        self.program, self.first_row, self.code, self.fused, self.calls = program, first_row, code, fused, calls
        self.products, self.formed = set(fused.values()), set[int]()
        self.values: dict[int, str] = {}
        self.angles = self.blocks = self.begin = 0
        self.offset = ""
        self.homes: dict[int, list[int]] = defaultdict(list)
        for place, position in enumerate(program.outputs):
            self.homes[position].append(first_row[""] + place)
        self.turns: dict[int, list[int]] = defaultdict(list)  # of each angle, its sine and its cosine
        for k, (op, a, _) in enumerate(program.operations):
            if op is SIN or op is COS:
                self.turns[a].append(k)

    def write(self, first: int = 0, until: int = sys.maxsize) -> None:
        """Write the operations at these positions; sine and cosine of an angle together, where the first stands."""
        for k, (op, a, _) in enumerate(self.program.operations[first:until], first):
            if op is INPUT or op is CONSTANT:
                if k in self.homes:
                    self._form(k, self._operand(k))
            elif k not in self.formed and k not in self.products:
                if op is SIN or op is COS:
                    self._turn(a)
                else:
                    self._form(k, self._value(k))
                self._divide()

    def _form(self, k: int, value: str) -> None:
        self.values[k] = value
        self.formed.add(k)
        for row in self.homes.get(k, ()):
            self._store(value, row)

    def _store(self, value: str, row: int) -> None:
        address = self._address(row, 1)
        self.code.do(f"store {self.code.vector} {value}, ptr {address}, align {BYTES[self.code.scalar]}")

    def _divide(self) -> None:
        """Begin a basic block where the last one is long enough."""
        if len(self.code.lines) - self.begin > BLOCK[self.code.pooled]:
            self._spread()
            self.blocks += 1
            self.code.lines.append(f"  br label %block{self.blocks}\nblock{self.blocks}:")
            self.begin = len(self.code.lines)

    def _spread(self) -> None:
        self.code.lines[self.begin :] = spread(self.code.lines[self.begin :])

    def _address(self, row: int, writes: int) -> str:
        """Return where a column's numbers of this group lie; those of later groups are called for."""
        place = self._further("%rows", 8 * row)
        column = self.code.new(f"load ptr, ptr {place}, align 8, !invariant.load !0")
        here = self.code.new(f"getelementptr {self.code.scalar}, ptr {column}, i64 {self.offset}")
        if self.calls:
            ahead = self._further(here, AHEAD)
            self.code.do(f"call void @llvm.prefetch.p0(ptr {ahead}, i32 {writes}, i32 {LEVEL}, i32 1)")
        return here

    def _further(self, base: str, distance: int) -> str:
        """Return an address some bytes further. LLVM, where it simplifies a single one, merges all basic blocks."""
        return self.code.new(f"getelementptr i8, ptr {base}, i64 {distance}") if distance else base

    def _input(self, source: str, column: int) -> str:
        address, align = self._address(self.first_row[source] + column, 0), BYTES[self.code.scalar]
        return self.code.new(f"load {self.code.vector}, ptr {address}, align {align}, !invariant.load !0")

    def _operand(self, k: int) -> str:
        op, a, b = self.program.operations[k]
        if op is CONSTANT:
            return self.code.constant(a)
        if k not in self.values:
            self.values[k] = self._input(a, b) if op is INPUT else self._kept(k)
        return self.values[k]

    def _total(self) -> str:
        if TOTAL not in self.values:
            self.values[TOTAL] = self._kept(TOTAL)
        return self.values[TOTAL]

    def _kept(self, k: int) -> str:
        raise AssertionError("all is written in one part")

    def _value(self, k: int) -> str:
        code = self.code
        op, a, b = self.program.operations[k]
        if k in self.fused:
            return self._sum(op, a, b, self.fused[k])
        if op in TWO:
            return code.two(TWO[op], self._operand(a), self._operand(b))
        return ONE[op](code, self._operand(a))

    def _sum(self, op: str, a: int, b: int, product: int) -> str:
        """x y + z, x y - z or z - x y."""
        code = self.code
        _, i, j = self.program.operations[product]
        x, y = self._operand(i), self._operand(j)
        if a == product:
            z = self._operand(b)
            return code.fma(x, y, z if op is ADD else code.neg(z))
        return code.fma(x if op is ADD else code.neg(x), y, self._operand(a))

    def _turn(self, argument: int) -> None:
        turn, wide = reduced(self.code, self._operand(argument)), self.code.doubles()
        square = turn.quarters, turn.quarters
        self.values[TOTAL] = wide.fma(*square, self._total()) if self.angles else wide.two("fmul", *square)
        self.angles += 1
        both = sine_and_cosine(self.code, turn)
        for k in self.turns[argument]:
            self._form(k, both[self.program.operations[k][0] is COS])

    def too_large(self) -> str:
        """A bit per sample: the sum of the squares of all quarter turns exceeds that of the largest, or is NaN."""
        code, wide = self.code, self.code.doubles()
        mask = wide.compare("ugt", self._total(), wide.constant(LARGEST_QUARTER**2))
        return code.new(f"bitcast {code.mask} {mask} to i{code.lanes}")


def spread(lines: Sequence[str]) -> list[str]:
    """Return the lines of a basic block ordered by the middle between the first moment at which each could begin and
    the last that would delay nothing, and a little by their place: LLVM keeps about to it, and a processor, which looks
    a few tens of instructions ahead, waits less. Moves and logic take no time here, and all arithmetic the same."""
    place: dict[str, int] = {}
    reads: list[list[int]] = []
    costs: list[int] = []
    begin: list[int] = []
    for k, line in enumerate(lines):
        name, _, what = line.strip().partition(" = ")
        reads.append([place[each] for each in REGISTER.findall(what or name) if each in place])
        costs.append(LATENCY if what.startswith(("f", "call")) else 0)
        begin.append(max((begin[x] + costs[x] for x in reads[k]), default=0))
        place[name] = k
    left = costs.copy()  # until the end of what depends on a line
    for k in range(len(lines) - 1, -1, -1):
        for x in reads[k]:
            left[x] = max(left[x], costs[x] + left[k])
    order = sorted(range(len(lines)), key=lambda k: 5 * (begin[k] - left[k]) + 2 * k)
    return [lines[k] for k in order]


class _Parts(Writer):
    """Writes a loop over some groups for each part of a program."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.size, wide = self.code.lanes * BYTES[self.code.scalar], 8 * self.code.lanes
        self.last = self._last_reads()
        self.starts = self._starts()
        places = self._places()
        self.group = wide + self.size * (1 + max(places.values(), default=-1))
        self.count = min(GROUPS, KEPT // self.group)
        if self.count < FEWEST:
            self.starts, places, self.count = [0], {}, 1
        self.places = {k: wide + self.size * place for k, place in places.items()} | {TOTAL: 0}

    def write(self, first: int = 0, until: int = sys.maxsize) -> None:
        lines, ends = self.code.lines, [*self.starts[1:], until]
        for p, (start, end) in enumerate(zip(self.starts, ends, strict=True)):
            self.values, self.offset, self.base = {}, f"%offset{p}", f"%base{p}"
            lines.append(LOOP.format(p=p, before=f"end{p - 1}" if p else "loop", lanes=self.code.lanes))
            self.begin = len(lines)
            super().write(start, end)
            if end == until:
                self._flag(p)
            elif TOTAL in self.values:
                self._keep(TOTAL, self.code.doubles())
            self._spread()
            lines.append(END.format(p=p, then="end" if end == until else f"loop{p + 1}", bytes=self.group))

    def _form(self, k: int, value: str) -> None:
        super()._form(k, value)
        if k in self.places:
            self._keep(k, self.code)

    def _keep(self, k: int, code: Code) -> None:
        address = self._further(self.base, self.places[k])
        code.do(f"store {code.vector} {self.values[k]}, ptr {address}, align {self.size}")

    def _kept(self, k: int) -> str:
        code = self.code.doubles() if k == TOTAL else self.code
        address = self._further(self.base, self.places[k])
        return code.new(f"load {code.vector}, ptr {address}, align {self.size}")

    def _flag(self, p: int) -> None:
        if self.angles:
            code, bits = self.code, max(8, self.code.lanes)
            these = code.new(f"zext i{code.lanes} {self.too_large()} to i64")
            address = code.new(f"getelementptr i{bits}, ptr %flags, i64 %i{p}")
            code.do(f"store i{bits} {code.new(f'trunc i64 {these} to i{bits}')}, ptr {address}, align 1")
            before = code.new("load i64, ptr %some")
            code.do(f"store i64 {code.new(f'or i64 {before}, {these}')}, ptr %some")

    def _last_reads(self) -> dict[int, int]:
        """For each value that an operation reads: where the last one does; factors are read where a sum takes them."""
        kinds, last = [op for op, _, _ in self.program.operations], dict[int, int]()
        for k, (op, a, b) in reversed([*enumerate(self.program.operations)]):
            if op is not INPUT and op is not CONSTANT:
                until = last[k] if k in self.products else k
                for x in (a,) if b is None else (a, b):
                    if last.get(x, 0) < until:
                        last[x] = until
        return {x: k for x, k in last.items() if x not in self.products and kinds[x] not in (INPUT, CONSTANT)}

    def _starts(self) -> list[int]:
        """Return where parts begin: where few values are alive, in the second half of as many operations as may be."""
        operations, starts = self.program.operations, [0]
        changes = np.zeros(len(operations) + 1, int)
        for x, k in self.last.items():
            changes[x + 1] += 1
            changes[k + 1] -= 1
        alive = changes[:-1].cumsum()
        costs = [0 if op in (INPUT, CONSTANT) else ANGLE if op in (SIN, COS) else 1 for op, _, _ in operations]
        done = np.cumsum([0, *costs])
        while done[-1] - done[starts[-1]] > PART:
            low, high = np.searchsorted(done, done[starts[-1]] + np.array([PART // 2, PART]))
            starts.append(int(low + alive[low:high].argmin()))
        return starts

    def _places(self) -> dict[int, int]:
        """Return places in memory for what later parts read; the next part may use those that are read no more."""
        first = {k: min(both) for both in self.turns.values() for k in both}
        begin = {x: bisect(self.starts, first.get(x, x)) for x in self.last}
        end = {x: bisect(self.starts, k) for x, k in self.last.items()}
        places: dict[int, int] = {}
        free, fresh = list[int](), count()
        for part in range(1, len(self.starts) + 1):
            for x in self.last:
                if begin[x] == part < end[x]:
                    places[x] = free.pop() if free else next(fresh)
            free += [place for x, place in places.items() if end[x] == part]
        return places
