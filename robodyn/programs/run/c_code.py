"""The `c` executor: a program as the text of a C99 function that needs nothing but <math.h>."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from robodyn.errors import InputError
from robodyn.programs.program import Program
from robodyn.programs.scalar import ADD, COS, DIV, EXP, INPUT, MUL, NEG, SIGN, SIN, SQRT, SUB

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

    def constant(value: str) -> str:
        lines.append(f"    const double t{len(lines)} = {value};")
        return f"t{len(lines) - 1}"

    def operation(form: str) -> Callable[..., str]:
        return lambda *operands: constant(form.format(*operands))

    functions = {op: operation(form) for op, form in FORMS.items()}
    found = program.evaluated(lambda source, column: f"{source}[{column}]", _literal, functions)
    operands = dict(zip(program.outputs, found, strict=True))
    operands |= {k: constant(operands[k]) for k in sorted(operands) if program.operations[k][0] is INPUT}
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
