"""The `c` executor: a program as the text of a C99 function that needs nothing but <math.h>."""

from __future__ import annotations

import math
from collections.abc import Mapping

from robodyn.errors import InputError
from robodyn.programs.program import Program
from robodyn.programs.scalar import ADD, CONSTANT, COS, DIV, EXP, INPUT, MUL, NEG, SIGN, SIN, SQRT, SUB

FORMS = {
    ADD: "{} + {}",
    SUB: "{} - {}",
    MUL: "{} * {}",
    DIV: "{} / {}",
    NEG: "-{}",
    SQRT: "sqrt({})",
    SIN: "sin({})",
    COS: "cos({})",
    EXP: "exp({})",
    SIGN: "({0} > 0.0) ? 1.0 : (({0} < 0.0) ? -1.0 : {0})",
}
"""Each operation on operands that are names or numbers."""


def prototype(name: str, widths: Mapping[str, int], output: str, outputs: int) -> str:
    """Return the head of the function, without semicolon: one array per source, in this order, then the outputs."""
    arrays = [f"const double {source}[{width}]" for source, width in widths.items()]
    return f"void {name}({', '.join([*arrays, f'double {output}[{outputs}]'])})"


def c_function(name: str, program: Program, widths: Mapping[str, int], output: str) -> str:
    """Return the function that computes the outputs of a program for one sample.

    Every operation is a constant of its own, in the program's order; the outputs are written when all of them are
    known, so `output` may be one of the inputs.

    Args:
        name: of the function.
        widths: how many numbers the array of each source has; sources that the program does not use are allowed.
        output: name of the array of outputs.

    Returns:
        Text that compiles as C99 without warnings, <math.h> being included.

    Raises:
        InputError: a constant of the program is not finite.

    Accuracy: each operation is rounded once unless the compiler fuses them; the sine, cosine and exponential are the
    platform's. Within 1e-13 of the largest output that robodyn finds.
    """
    lines: list[str] = []
    operands: list[str] = []
    for op, a, b in program.operations:
        if op is INPUT:
            operands.append(f"{a}[{b}]")
        elif op is CONSTANT:
            operands.append(_literal(a))
        else:
            value = FORMS[op].format(*(operands[arg] for arg in (a, b) if arg is not None))
            operands.append(f"t{len(lines)}")
            lines.append(f"    const double {operands[-1]} = {value};")
    for k in sorted(set(program.outputs)):
        if program.operations[k][0] is INPUT:
            lines.append(f"    const double t{len(lines)} = {operands[k]};")
            operands[k] = f"t{len(lines) - 1}"
    used = {source for source, _ in program.inputs}
    lines += [f"    (void){source};" for source in widths if source not in used]
    lines += [f"    {output}[{place}] = {operands[k]};" for place, k in enumerate(program.outputs)]
    head = prototype(name, widths, output, len(program.outputs))
    return "\n".join([head, "{", *lines, "}"]) + "\n"


def comment(text: str) -> str:
    """Text that may stand in a C comment: ASCII, without the ends of comments and without trigraphs."""
    plain = "".join(c if c == "\n" or (c.isprintable() and c.isascii()) else ascii(c)[1:-1] for c in text)
    return plain.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?")


def _literal(value: float) -> str:
    if not math.isfinite(value):
        raise InputError("a constant of the equations overflows", remedy="check the masses, lengths and gravity")
    return repr(value)
