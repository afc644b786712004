"""Derivatives of traced scalars, as further operations on the same tape."""

from __future__ import annotations

import operator
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import compress

from robodyn.programs.program import Program, trace
from robodyn.programs.scalar import ADD, CONSTANT, COS, DIV, EXP, INPUT, MUL, NEG, SIGN, SIN, SQRT, SUB, Tape, Traced
from robodyn.programs.vectors import Scalar, cos, exp, sign, sin, sqrt

Direction = Mapping[Traced, Scalar]
"""How fast inputs change along a direction; those that it does not name stay as they are."""

Row = list[Scalar]
Rates = dict[int, Scalar]
Edges = dict[Traced, list[tuple[Traced, Scalar]]]
"""Of each operation, operands first: the operands that change along some direction, and its derivative by each."""


def jacobian(outputs: Sequence[Scalar], directions: Sequence[Direction]) -> list[Row]:
    """Return the derivative of every output along every direction: (m, n) scalars, 0.0 where nothing connects them.

    The derivative of `sign` is 0: at its step there is none, and none is made up.

    Method: forwards, the rate of every operation along each direction from those of its operands; and backwards, the
    weight with which each enters an output from those of what uses it. Each row is kept one way, so that all together
    need few operations. Griewank, Walther 2008, chapters 3 and 15.

    Accuracy: as that of the outputs; each operation contributes a few roundings of its own partial derivatives.
    """
    tape = _tape(outputs)
    edges = _edges(outputs, directions)
    forwards = _forwards(outputs, directions, edges)
    weights: dict[Traced, Rates] = defaultdict(dict)
    for i, output in enumerate(outputs):
        if isinstance(output, Traced):
            weights[output][i] = 1.0
    for node in reversed(edges):
        if node in weights:
            for operand, partial in edges[node]:
                weights[operand] = _added(weights[operand], weights, [(node, partial)])
    columns = [_added({}, weights, direction.items()) for direction in directions]
    backwards = [[column.get(i, 0.0) for column in columns] for i in range(len(outputs))]
    return _fewest(forwards, backwards, tape)


def along(outputs: Sequence[Scalar], direction: Direction) -> Row:
    """Return how fast outputs change along one direction, forwards; accuracy as of `jacobian`."""
    return [rate for (rate,) in _forwards(outputs, [direction], _edges(outputs, [direction]))]


def derivative(program: Program, inputs: Sequence[tuple[str, int]]) -> Program:
    """Return the program of d outputs / d inputs, which are (source, column) pairs, row by row."""

    def outputs(tape: Tape) -> Iterable[Scalar]:
        values = again(program, tape)
        return [x for row in jacobian(values, [{tape.input(*each): 1.0} for each in inputs]) for x in row]

    return trace(outputs)


def again(program: Program, tape: Tape, given: Mapping[tuple[str, int], Scalar] | None = None) -> list[Scalar]:
    """Return the outputs of a program traced again on another tape, with scalars in the place of some inputs."""
    known = given or {}

    def column(source: str, index: int) -> Scalar:
        return known[source, index] if (source, index) in known else tape.input(source, index)

    return program.evaluated(column, float, FUNCTIONS)


FUNCTIONS: dict[str, Callable[..., Scalar]] = {
    NEG: operator.neg,
    ADD: operator.add,
    SUB: operator.sub,
    MUL: operator.mul,
    DIV: operator.truediv,
    SQRT: sqrt,
    SIN: sin,
    COS: cos,
    SIGN: sign,
    EXP: exp,
}
"""Each operation on scalars of any kind."""


def _tape(outputs: Iterable[Scalar]) -> Tape:
    return next((output.tape for output in outputs if isinstance(output, Traced)), Tape())


def _edges(outputs: Sequence[Scalar], directions: Sequence[Direction]) -> Edges:
    changing = {node for direction in directions for node in direction}
    tape, edges = _tape(outputs), Edges()
    for node in list(compress(tape.nodes.values(), _users([outputs], tape))):
        if node.op in _PARTIALS and (node.a in changing or node.b in changing):
            parts = zip((node.a, node.b), _PARTIALS[node.op](node), strict=False)
            edges[node] = [(operand, partial) for operand, partial in parts if operand in changing]
            changing.add(node)
    return edges


def _forwards(outputs: Sequence[Scalar], directions: Sequence[Direction], edges: Edges) -> list[Row]:
    rates: dict[Traced, Rates] = defaultdict(dict)
    for k, direction in enumerate(directions):
        for node, rate in direction.items():
            rates[node][k] = rate
    for node, changes in edges.items():
        rates[node] = _added({}, rates, changes)
    rows = [rates.get(output, {}) if isinstance(output, Traced) else {} for output in outputs]
    return [[row.get(k, 0.0) for k in range(len(directions))] for row in rows]


def _users(rows: Iterable[Iterable[Scalar]], tape: Tape) -> list[int]:
    """Return for each operation of a tape which rows need it: bit k for row k; 0 for inputs and constants."""
    bits = [0] * len(tape.nodes)
    for k, row in enumerate(rows):
        for x in row:
            if isinstance(x, Traced):
                bits[x.serial] |= 1 << k
    for node, own in zip(reversed(tape.nodes.values()), reversed(bits), strict=True):
        if node.op is INPUT or node.op is CONSTANT:
            bits[node.serial] = 0
        elif own:
            bits[node.a.serial] |= own
            if node.b is not None:
                bits[node.b.serial] |= own
    return bits


_PARTIALS: dict[str, Callable[[Traced], tuple[Scalar, ...]]] = {
    NEG: lambda node: (-1.0,),
    ADD: lambda node: (1.0, 1.0),
    SUB: lambda node: (1.0, -1.0),
    MUL: lambda node: (node.b, node.a),
    DIV: lambda node: (1.0 / node.b, -(node * (1.0 / node.b))),
    SQRT: lambda node: (0.5 / node,),
    SIN: lambda node: (node.a.cos(),),
    COS: lambda node: (-node.a.sin(),),
    EXP: lambda node: (node,),
}
"""The derivatives of each operation by its operands; of `sign` there is none."""


def _added(out: Rates, rows: Mapping[Traced, Rates], parts: Iterable[tuple[Traced, Scalar]]) -> Rates:
    """Return a row of a sparse matrix, which changes, with rows of another added, each times a factor."""
    zeros = False
    for node, factor in parts:
        same, opposite = factor == 1.0, factor == -1.0
        if same and not out:
            out.update(rows[node])
            continue
        for k, x in rows[node].items():
            change = x if same else -x if opposite else x * factor
            out[k] = total = out[k] + change if k in out else change
            zeros = zeros or not (isinstance(total, Traced) or total != 0.0)
    return {k: x for k, x in out.items() if isinstance(x, Traced) or x != 0.0} if zeros else out


def _fewest(forwards: list[Row], backwards: list[Row], tape: Tape) -> list[Row]:
    """Return all rows one way or all the other, then row by row the other way where that saves operations."""
    rows, count = [*forwards, *backwards], len(forwards)
    shares = Counter(_users(rows, tape))  # operations that the same rows need

    def size(taken: int) -> int:
        return sum([operations for bits, operations in shares.items() if bits & taken])

    one_way = (1 << count) - 1
    (least, taken), before = min((size(taken), taken) for taken in (one_way, one_way << count)), -1
    while taken != before:
        before = taken
        for i in range(count):
            other = taken ^ (1 << i | 1 << i + count)
            if (needed := size(other)) < least:
                least, taken = needed, other
    return [rows[i + count * (taken >> i + count & 1)] for i in range(count)]
