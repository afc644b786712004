"""Programs as text of other languages: C99, and Python for NumPy, JAX, PyTorch and CasADi.

All are written from one list of statements, one per operation. The functions of scalars are the same text for all:
`q[0] * t1` and `sin(t2)` mean what the module imports. Nothing in them is changed in place and nothing depends on
values, so that JAX and PyTorch can map, compile and differentiate them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from itertools import count
from textwrap import indent
from typing import NamedTuple

from robodyn.errors import InputError
from robodyn.programs.program import Program
from robodyn.programs.scalar import ADD, CONSTANT, COS, DIV, EXP, INPUT, MUL, NEG, SIGN, SIN, SQRT, SUB

ARITHMETIC = {
    ADD: "{} + {}",
    SUB: "{} - {}",
    MUL: "{} * {}",
    DIV: "{} / {}",
    NEG: "-{}",
    SQRT: "sqrt({})",
    SIN: "sin({})",
    COS: "cos({})",
    EXP: "exp({})",
    SIGN: "sign({})",
}
"""Each operation on operands that are names or numbers."""


class Language(NamedTuple):
    """How operations are written: what gives a value a name, and each operation. Where it `reuses` names, one is given
    to another value when the first is needed no more: of arrays, that frees memory."""

    statement: str
    forms: Mapping[str, str] = ARITHMETIC
    reuses: bool = False


def statements(program: Program, language: Language) -> tuple[list[str], list[str]]:
    """Return a statement per operation, in the program's order, and the operand that each output is; inputs are written
    as `q[0]`, numbers with all their digits. InputError where a constant is not finite."""
    named = [op not in (INPUT, CONSTANT) for op, _, _ in program.operations]
    last = {i: k for k, (_, *operands) in enumerate(program.operations) if named[k] for i in operands}
    last |= dict.fromkeys(program.outputs, len(named))  # which are always needed
    lines: list[str] = []
    written: list[str] = []
    free: list[str] = []
    names = map("t{}".format, count())
    for k, (op, a, b) in enumerate(program.operations):
        if op is INPUT:
            written.append(f"{a}[{b}]")
        elif op is CONSTANT:
            written.append(literal(a))
        else:
            operands = (a,) if b is None else (a, b)
            value = language.forms[op].format(*(written[i] for i in operands))
            if language.reuses:
                free += [written[i] for i in dict.fromkeys(operands) if last[i] == k and named[i]]
            written.append(free.pop() if free else next(names))
            lines.append(language.statement.format(written[k], value))
    return lines, [written[i] for i in program.outputs]


def literal(value: float) -> str:
    """Return the number as Python and C write it; raise if it is not finite."""
    if not math.isfinite(value):
        raise InputError("a constant of the equations overflows", remedy="check the masses, lengths and gravity")
    return repr(value)


C = Language("    const double {} = {};", {**ARITHMETIC, SIGN: "({0} > 0.0) ? 1.0 : (({0} < 0.0) ? -1.0 : {0})"})


def prototype(name: str, widths: Mapping[str, int], results: Mapping[str, int]) -> str:
    """Return the head of the function, without semicolon: the arrays that it reads, then those that it writes to."""
    arrays = [f"const double {source}[{width}]" for source, width in widths.items()]
    return f"void {name}({', '.join([*arrays, *(f'double {result}[{size}]' for result, size in results.items())])})"


def c_function(name: str, program: Program, widths: Mapping[str, int], results: Mapping[str, int]) -> str:
    """Return the function that computes the outputs of a program for one sample: C99, <math.h> being included.

    The results are written when all of them are known, so they may stand where the inputs do.

    Args:
        widths: how many numbers the array of each source has; sources that the program does not use are allowed.
        results: names of the arrays of outputs, and how many outputs go into each.

    Accuracy: within 1e-13 of the largest output that robodyn finds: each operation is rounded once unless the compiler
    fuses them; sine, cosine and exponential are the platform's.
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


PYTHON = Language("    {} = {}", reuses=True)
WIDTH = 120


class Library(NamedTuple):
    """A library whose functions are written.

    Attributes:
        imports: what a module begins with; sin, cos, exp, sqrt and sign are among them.
        support: what every function of the module calls; function: that of arrays, from that of scalars.
        batch: how the shapes of arrays begin, which are columns where this is empty.
    """

    title: str
    imports: str
    support: str
    function: str
    batch: str
    notes: str

    def shape(self, of_one: tuple[int, ...]) -> str:
        """Return how the shape of an array is written that has this shape for one sample."""
        return f"({', '.join([self.batch, *map(str, of_one)] if self.batch else map(str, (*of_one, 1)[:2]))})"


_ARRAYS = '''
def _applied(scalars, arrays, widths, shapes):
    """Call a function of scalars with the columns of arrays, and make arrays of the scalars that it returns."""
    given = [{library}.{convert}(array) for array in arrays.values()]
    for name, array, width in zip(arrays, given, widths):
        if array.ndim == 0 or array.shape[-1] != width:
            raise ValueError(f"{{name}} has shape {{tuple(array.shape)}}, not (..., {{width}})")
    batch = {library}.broadcast_shapes(*(array.shape[:-1] for array in given))
    zero = {library}.zeros_like(given[0][..., 0])
    columns = ([array[..., k] for k in range(width)] for array, width in zip(given, widths))
    entries = [zero + entry if isinstance(entry, float) else entry for entry in scalars(*columns)]
    entries = [{library}.broadcast_to(entry, batch) for entry in entries]
    results = []
    for shape in shapes:
        size = prod(shape)
        results.append({library}.stack(entries[:size], -1).reshape((*batch, *shape)))
        entries = entries[size:]
    return results[0] if len(results) == 1 else tuple(results)
'''
_ARRAY_FUNCTION = """
def {name}({arguments}):
{doc}
    return _applied(_{name}, {{{named}}}, {widths}, {shapes})
"""
_CASADI = '''
def _function(name, scalars, widths, shapes):
    """Return the casadi.Function of a function of scalars; zeros of its matrices are structural."""
    arguments = {source: casadi.SX.sym(source, width) for source, width in widths.items()}
    entries = scalars(*arguments.values())
    results = {}
    for result, (rows, columns) in shapes.items():
        size = rows * columns
        column = casadi.SX(casadi.vertcat(*entries[:size]))
        results[result] = casadi.sparsify(casadi.reshape(column, columns, rows).T)
        entries = entries[size:]
    return casadi.Function(name, [*arguments.values()], [*results.values()], [*arguments], [*results])
'''
_CASADI_FUNCTION = """
{name} = _function("{name}", _{name}, {{{named_widths}}}, {{{named_shapes}}})
{doc}
"""


def _arrays(title: str, imports: str, library: str, convert: str, notes: str) -> Library:
    head = f"from math import prod\n\n{imports}"
    return Library(title, head, _ARRAYS.format(library=library, convert=convert), _ARRAY_FUNCTION, "...", notes)


LIBRARIES = {
    "numpy": _arrays(
        "NumPy",
        "import numpy as np\nfrom numpy import cos, exp, sin, sqrt\n\n\n"
        'def sign(x):\n    """Return the sign of the real part, so that complex steps find a derivative of 0."""\n'
        "    return np.sign(np.real(x))",
        "np",
        "asarray",
        "Numbers have the type of the arrays: float64, float32, or complex for derivatives by complex steps.",
    ),
    "jax": _arrays(
        "JAX",
        "import jax.numpy as jnp\nfrom jax.numpy import cos, exp, sign, sin, sqrt",
        "jnp",
        "asarray",
        "They can be given to jax.jit, jax.vmap, jax.grad, jax.jacfwd and jax.jacrev, and run where their arrays are.\n"
        'JAX computes in float32 unless jax.config.update("jax_enable_x64", True) comes first.',
    ),
    "torch": _arrays(
        "PyTorch",
        "import torch\nfrom torch import cos, exp, sign, sin, sqrt",
        "torch",
        "as_tensor",
        "They can be given to torch.func.vmap, jacfwd and jacrev, to torch.compile and to autograd. Type and device\n"
        "are those of the tensors.",
    ),
    "casadi": Library(
        "CasADi",
        "import casadi\nfrom casadi import cos, exp, sign, sin, sqrt",
        _CASADI,
        _CASADI_FUNCTION,
        "",
        "Each is a casadi.Function of column vectors, built of SX; call it with numbers, SX or MX.",
    ),
}
"""By the name that a user gives."""


def python_function(
    library: Library,
    name: str,
    program: Program,
    widths: Mapping[str, int],
    shapes: Mapping[str, tuple[int, ...]],
    doc: str,
) -> str:
    """Return two functions: `_name` of scalars with the program's operations, and `name` of arrays, which calls it.

    Args: widths: of the array of each source; shapes: of the results, whose entries the outputs are, one after another;
    doc: docstring of the function of arrays.
    """
    lines, outputs = statements(program, PYTHON)
    scalars = [f"def _{name}({', '.join(widths)}):", *lines, "    return [", *wrapped(outputs, 8), "    ]"]
    of_arrays = library.function.format(
        name=name,
        arguments=", ".join(widths),
        doc=indent(docstring(doc), "    " if library.function is _ARRAY_FUNCTION else ""),
        named=", ".join(f'"{source}": {source}' for source in widths),
        widths=tuple(widths.values()),
        shapes=list(shapes.values()),
        named_widths=", ".join(f'"{source}": {width}' for source, width in widths.items()),
        named_shapes=", ".join(f'"{result}": {(*shape, 1)[:2]}' for result, shape in shapes.items()),
    )
    return "\n".join(scalars) + "\n\n" + of_arrays


def wrapped(entries: Iterable[str], indentation: int) -> list[str]:
    """Return the lines of entries with commas between them and behind the last."""
    lines, room = [""], WIDTH - indentation
    for entry in entries:
        if lines[-1] and len(lines[-1]) + len(entry) + 2 > room:
            lines.append("")
        lines[-1] += f"{' ' if lines[-1] else ''}{entry},"
    return [" " * indentation + line for line in lines]


def docstring(text: str) -> str:
    """Return a literal in triple quotes whose value is the text."""
    plain = "".join(c if c == "\n" or c.isprintable() else ascii(c)[1:-1] for c in text)
    return '"""' + plain.replace("\\", "\\\\").replace('"""', '\\"\\"\\"') + '"""'
