"""A program as one LLVM function of a single sample: an array per source, and one of outputs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from robodyn.programs.program import Program
from robodyn.programs.run.llvm.code import Code
from robodyn.programs.run.llvm.kernel import Writer, fused_products
from robodyn.programs.scalar import CONSTANT, COS, INPUT, SIN

FRAME = """\
{declared}
define i64 @sample({arguments}, ptr %to) #0 {{
entry:
{body}
  ret i64 0
{refused}
}}
define i64 @arrays(ptr %all) #0 {{
entry:
{loads}
  %flag = call i64 @sample({given}, ptr %to)
  ret i64 %flag
}}
attributes #0 = {{ nounwind }}
"""


def sample_kernel(program: Program, widths: Mapping[str, int]) -> str:
    """Return the LLVM IR of `i64 sample(const double *source..., double *to)`, and of `i64 arrays(double **all)`.

    There is an argument for every source of `widths`, in this order, and the outputs come last. All inputs are read
    before the first output is written, so the arrays may overlap. The function returns 0, or 1 and writes nothing where
    an angle is too large to be reduced accurately or is not finite. `arrays` is the same with the addresses of all
    arrays in one.

    Args:
        widths: the numbers in the array of each source; the program may leave some alone.
    """
    writer = _Sample(program, widths)
    writer.write()
    names = [f"%source{k}" for k in range(len(widths))]
    loads = (
        f"  {name}_at = getelementptr ptr, ptr %all, i64 {k}\n  {name} = load ptr, ptr {name}_at"
        for k, name in enumerate([*names, "%to"])
    )
    given = ", ".join(f"ptr {name}" for name in names)
    return FRAME.format(
        declared="\n".join(sorted(writer.code.declared)),
        arguments=given,
        given=given,
        loads="\n".join(loads),
        body="\n".join(writer.code.lines),
        refused="refused:\n  ret i64 1" if writer.quarters else "",
    )


class _Sample(Writer):
    """Writes a program that works on one sample."""

    def __init__(self, program: Program, widths: Mapping[str, int]) -> None:
        super().__init__(program, program.rows(widths), Code("double", 1), fused_products(program), False)
        self.early: dict[int, str] = {}
        self.homes = {
            self.first_row[source] + column: (f"%source{k}", column)
            for k, (source, width) in enumerate(widths.items())
            if source in self.first_row
            for column in range(width)
        }
        self.homes |= {self.first_row[""] + place: ("%to", place) for place in range(len(program.outputs))}
        rows = (self.first_row[source] + column for source, column in sorted(program.inputs))
        self.inputs = {row: self.code.new(f"load <1 x double>, ptr {self._address(row, 0)}, align 8") for row in rows}

    def write(self) -> None:
        """Writes the angles, a way out where they are too large, and the rest."""
        self.values = [""] * len(self.program.operations)
        for k in self._below_angles():
            self.early[k] = self.values[k] = self._value(k, *self.program.operations[k])
            self._divide()
        if self.quarters:
            self.code.lines.append(f"  br i1 {self.too_large()}, label %refused, label %fine\nfine:")
        self.values = []
        super().write()

    def _below_angles(self) -> list[int]:
        """Return the positions of all sines and cosines, and of what they are computed from, in order."""
        operations, needed = self.program.operations, set[int]()
        for k in reversed(range(len(operations))):
            op, a, b = operations[k]
            if op is SIN or op is COS or k in needed:
                needed.add(k)
                needed.update(() if op in (INPUT, CONSTANT) else (x for x in (a, b) if x is not None))
        return sorted(needed - set(self.fused.values()))

    def _value(self, k: int, op: str, a: Any, b: Any) -> str:
        return self.early[k] if k in self.early else super()._value(k, op, a, b)

    def _input(self, row: int) -> str:
        return self.inputs[row]

    def _address(self, row: int, writes: int) -> str:
        array, place = self.homes[row]
        return self.code.new(f"getelementptr double, ptr {array}, i64 {place}")
