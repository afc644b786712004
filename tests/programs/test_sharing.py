"""What a program keeps: every operation once, and only what some output needs."""

from __future__ import annotations

import gc

import pytest
from helpers.oracles import golden_model
from helpers.program_values import evaluated

from robodyn.dynamics.plan import Plan
from robodyn.programs.program import trace
from robodyn.programs.scalar import CONSTANT, INPUT, Tape
from robodyn.programs.vectors import cos, sin
from robodyn.scene.scene import Scene


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


def test_shared_operations_are_counted_once():
    def twice(tape):
        x, y = tape.input("q", 0), tape.input("q", 1)
        return [sin(x) * cos(y) + x, cos(y) * sin(x) - x]

    assert trace(twice).counts == {"sin": 1, "cos": 1, "mul": 1, "add": 1, "sub": 1}


def test_what_no_output_needs_is_pruned():
    def wasteful(tape):
        x, y = tape.input("q", 0), tape.input("q", 1)
        assert (sin(y) / x) * y is not None
        return [x * x]

    program = trace(wasteful)
    assert program.counts == {"mul": 1}
    assert program.inputs == {("q", 0)}


def test_outputs_may_be_inputs_constants_and_repeated():
    program = trace(lambda tape: [tape.input("q", 1), 3.0, tape.input("q", 1), 3.0])
    assert program.size == 0
    assert [program.operations[k][:2] for k in program.outputs] == [(INPUT, "q"), (CONSTANT, 3.0)] * 2


@pytest.mark.parametrize("name", ["tree15_bf2_skew0.3", "puma560_corke"])
def test_of_a_robot(name):
    """Operands stand before their operations, nothing is written twice, and everything is used."""
    program = Plan(golden_model(name), Scene()).wrenches(joints=True)
    operations = program.operations
    assert len(set(operations)) == len(operations)
    used = set(program.outputs)
    for k, (op, a, b) in enumerate(operations):
        if op not in (INPUT, CONSTANT):
            operands = {x for x in (a, b) if x is not None}
            assert max(operands) < k
            used |= operands
    assert used == set(range(len(operations)))
    assert program.size == sum(op not in (INPUT, CONSTANT) for op, _, _ in operations)


def test_which_output_is_finished_first_does_not_change_what_is_computed():
    def outputs(tape):
        x, y, z = (tape.input("q", i) for i in range(3))
        return [x * y + z, sin(x * y), cos(z) * x]

    plain, ordered = trace(outputs), trace(outputs, [2, 1, 0])
    assert plain.operations != ordered.operations
    assert plain.counts == ordered.counts
    state = {"q": [0.3, 1.7, -2.9]}
    assert evaluated(plain, state) == evaluated(ordered, state)


def test_a_deep_expression_needs_no_recursion():
    def deep(tape):
        x = tape.input("q", 0)
        for _ in range(20_000):
            x = sin(x) + 1.0
        return [x]

    assert trace(deep).size == 40_000


@pytest.mark.parametrize("enabled", [True, False])
def test_the_collector_of_garbage_is_left_as_it_was(enabled):
    """Also where the traced function raises."""
    before = gc.isenabled()
    try:
        (gc.enable if enabled else gc.disable)()
        trace(lambda tape: [tape.input("x", 0)])
        assert gc.isenabled() is enabled
        with pytest.raises(ZeroDivisionError):
            trace(lambda tape: [1 / 0])
        assert gc.isenabled() is enabled
    finally:
        (gc.enable if before else gc.disable)()


def test_a_trace_leaves_nothing_to_collect():
    """Nor does a chain of many operations overflow the stack when it goes away."""

    def chain(tape):
        x = tape.input("x", 0)
        total = x
        for k in range(100_000):
            total = (total + x) * (1.0 + k)
        return [total]

    gc.freeze()
    gc.collect()
    program = trace(chain)
    assert gc.collect() < 1000
    assert program.size == 199_999
