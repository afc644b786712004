"""Programs keep every operation once and only what is needed; folding changes no bit of what floats would be."""

from __future__ import annotations

import gc
import math
import operator

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from robodyn.programs.program import trace
from robodyn.programs.scalar import Tape, Traced
from robodyn.programs.vectors import cos, exp, sign, sin

CONSTANTS = [0.0, -0.0, 1.0, -1.0, 2.0, -0.5, 3.7, -1e-3, 1e8]
BINARY = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}


OF_TRACED = {"neg": operator.neg, "sin": sin, "cos": cos, "exp": exp, "sign": sign}
OF_FLOATS = OF_TRACED | {"sin": math.sin, "cos": math.cos, "exp": math.exp}
ALL = OF_FLOATS | {"add": operator.add, "sub": operator.sub, "mul": operator.mul, "div": operator.truediv}
INPUTS = 4


leaves = st.one_of(
    st.tuples(st.just("input"), st.integers(0, INPUTS - 1)), st.tuples(st.just("constant"), st.sampled_from(CONSTANTS))
)
expressions = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.tuples(st.sampled_from(sorted(BINARY)), inner, inner),
        st.tuples(st.sampled_from(sorted(OF_TRACED)), inner),
    ),
    max_leaves=25,
)
values = st.lists(
    st.one_of(st.sampled_from(CONSTANTS), st.floats(-1e3, 1e3, allow_subnormal=False)),
    min_size=INPUTS,
    max_size=INPUTS,
)


def compute(tree, inputs, unary):
    """The value of an expression; with floats every intermediate value must be finite."""
    op, *rest = tree
    if op == "input":
        return inputs[rest[0]]
    if op == "constant":
        return rest[0]
    parts = [compute(part, inputs, unary) for part in rest]
    result = (BINARY if op in BINARY else unary)[op](*parts)
    if isinstance(result, float) and not math.isfinite(result):
        raise OverflowError
    return result


def checked(tree, inputs):
    try:
        return compute(tree, inputs, OF_FLOATS)
    except (ZeroDivisionError, OverflowError):
        return None


def traced(tree):
    """The program of an expression; one whose constants alone are not finite is no test."""
    try:
        return trace(lambda tape: [compute(tree, [tape.input("x", i) for i in range(INPUTS)], OF_TRACED)])
    except (ZeroDivisionError, OverflowError):
        return None


@example(("neg", ("-", ("input", 0), ("input", 1))), [3.0, 5.0, 7.0, 9.0])
@given(expressions, values)
def test_in_plain_floats(tree, inputs):
    expected, program = checked(tree, inputs), traced(tree)
    assume(expected is not None and program is not None)
    assert program.evaluated(lambda _, index: float(inputs[index]), float, ALL) == [expected]


RULES = {
    "x + 0": (lambda x, y: x + 0.0, "x"),
    "0 + x": (lambda x, y: 0.0 + x, "x"),
    "x - 0": (lambda x, y: x - 0.0, "x"),
    "0 - x": (lambda x, y: 0.0 - x, "neg"),
    "x * 1": (lambda x, y: x * 1.0, "x"),
    "x * -1": (lambda x, y: x * -1.0, "neg"),
    "x / 1": (lambda x, y: x / 1.0, "x"),
    "x * 0": (lambda x, y: 0 * x, 0.0),
    "0 / x": (lambda x, y: 0.0 / x, 0.0),
    "x - x": (lambda x, y: x - x, 0.0),
    "-(-x)": (lambda x, y: operator.neg(-x), "x"),
    "-(x - y)": (lambda x, y: -(x - y), "sub"),
    "x + -y": (lambda x, y: x + -y, "sub"),
    "-x + y": (lambda x, y: -x + y, "sub"),
    "x - -y": (lambda x, y: x - -y, "add"),
    "(-x) (-y)": (lambda x, y: (-x) * (-y), "mul"),
    "cos(-x)": (lambda x, y: cos(-x), "cos"),
}


@pytest.mark.parametrize("rule", RULES)
def test_rule(rule):
    """Each leaves the one operation that is needed, or none."""
    function, expected = RULES[rule]
    seen = []
    program = trace(lambda tape: seen.append(function(tape.input("s", 0), tape.input("s", 1))) or seen)
    if isinstance(expected, float):
        assert seen == [expected]
        assert not isinstance(seen[0], Traced)
    assert program.counts == ({} if expected == "x" or isinstance(expected, float) else {expected: 1})


def test_signs_move_outward_and_meet():
    program = trace(lambda tape: [-tape.input("s", 0) * tape.input("s", 1) + sin(-tape.input("s", 2))])
    assert program.counts == {"mul": 1, "sin": 1, "add": 1, "neg": 1}


def test_the_same_operation_is_the_same_node():
    tape = Tape()
    x, y = tape.input("q", 0), tape.input("q", 1)
    assert tape.input("q", 0) is x
    assert x * y is y * x
    assert x + y is y + x
    assert x - y is not y - x
    assert sin(x) is sin(x)
    assert x * 2.0 is 2 * x
    assert tape.input("qd", 0) is not x


def test_what_no_output_needs_is_pruned():
    program = trace(lambda tape: [sin(tape.input("q", 1)) * 2.0, tape.input("q", 0) * tape.input("q", 0)][1:])
    assert (program.counts, program.inputs) == ({"mul": 1}, {("q", 0)})


def test_a_trace_leaves_nothing_to_collect():
    """Nor does a chain of many operations overflow the stack; the collector is left as it was, also after errors."""

    def chain(tape):
        x = tape.input("x", 0)
        total = x
        for k in range(5_000):
            total = (total + x) * (1.0 + k)
        return [total]

    gc.freeze()
    gc.collect()
    program = trace(chain)
    assert gc.collect() < 1000
    assert program.size == 9_999
    enabled = gc.isenabled()
    with pytest.raises(ZeroDivisionError):
        trace(lambda tape: [1 / 0])
    assert gc.isenabled() is enabled
