"""A program as a C99 function that needs nothing but <math.h>."""

from __future__ import annotations

from collections.abc import Mapping

from robodyn.programs.export.statements import ARITHMETIC, Language, statements
from robodyn.programs.program import Program
from robodyn.programs.scalar import SIGN

C = Language("    const double {} = {};", {**ARITHMETIC, SIGN: "({0} > 0.0) ? 1.0 : (({0} < 0.0) ? -1.0 : {0})"})


def prototype(name: str, widths: Mapping[str, int], results: Mapping[str, int]) -> str:
    """Return the head of the function, without semicolon: the arrays that it reads, then those that it writes to."""
    arrays = [f"const double {source}[{width}]" for source, width in widths.items()]
    return f"void {name}({', '.join([*arrays, *(f'double {result}[{size}]' for result, size in results.items())])})"


def c_function(name: str, program: Program, widths: Mapping[str, int], results: Mapping[str, int]) -> str:
    """Return the function that computes the outputs of a program for one sample.

    The results are written when all of them are known, so they may stand where the inputs do.

    Args:
        name: of the function.
        widths: how many numbers the array of each source has; sources that the program does not use are allowed.
        results: names of the arrays of outputs, and how many outputs go into each.

    Returns:
        Text that compiles as C99 without warnings, <math.h> being included.

    Raises:
        InputError: a constant of the program is not finite.

    Accuracy: each operation is rounded once unless the compiler fuses them; the sine, cosine and exponential are the
    platform's. Within 1e-13 of the largest output that robodyn finds.
    """
    lines, outputs = statements(program, C)
    inputs = {f"{source}[{column}]" for source, column in program.inputs}
    kept = {text: f"in{k}" for k, text in enumerate(sorted(inputs & {*outputs}))}
    lines += [f"    const double {copy} = {text};" for text, copy in kept.items()]
    used = {source for source, _ in program.inputs}
    lines += [f"    (void){source};" for source in widths if source not in used]
    places = [f"{result}[{k}]" for result, size in results.items() for k in range(size)]
    lines += [f"    {place} = {kept.get(text, text)};" for place, text in zip(places, outputs, strict=True)]
    return "\n".join([prototype(name, widths, results), "{", *lines, "}"]) + "\n"


def comment(text: str) -> str:
    """Text that may stand in a C comment: ASCII, without the ends of comments and without trigraphs."""
    plain = "".join(c if c == "\n" or (c.isprintable() and c.isascii()) else ascii(c)[1:-1] for c in text)
    return plain.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?")
