"""Derivatives of programs against differences of their values with 60 digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from helpers.counted_calls import calls
from helpers.exact_rates import exact_rates
from helpers.oracles import robot
from helpers.random_programs import seeded

from robodyn.dynamics.plan import Plan
from robodyn.programs.derivative import again, derivative, jacobian
from robodyn.programs.program import Program, trace
from robodyn.programs.run.multiprecision import Multiprecision
from robodyn.programs.scalar import CONSTANT, Tape
from robodyn.programs.vectors import sign, sin
from robodyn.scene.scene import Scene

ROWS = 2


def inputs_of(widths: dict[str, int]) -> list[tuple[str, int]]:
    return [(source, i) for source, width in widths.items() for i in range(width)]


def worst(program: Program, widths: dict[str, int], seed: int) -> mpmath.mpf:
    """The largest error of a derivative with 50 digits, as a part of the largest that this output has."""
    inputs = inputs_of(widths)
    rng = np.random.default_rng(seed)
    sources = {name: rng.uniform(-2.0, 2.0, (ROWS, width)) for name, width in widths.items()}
    found = Multiprecision(derivative(program, inputs), digits=50)(sources, ROWS).reshape(ROWS, -1, len(inputs))
    expected = exact_rates(program, [{each: 1} for each in inputs], sources)
    return (abs(found - expected) / np.maximum(abs(expected).max(axis=2, keepdims=True), 1)).max()


@pytest.mark.parametrize("operations", [4, 15, 60])
@pytest.mark.parametrize("first", [0, pytest.param(8, marks=pytest.mark.slow)])
def test_random_programs(operations: int, first: int) -> None:
    for seed in range(first, first + 8):
        assert worst(*seeded(seed, operations), seed) < 1e-35


def test_a_step_and_a_direction() -> None:
    """A sign has no slope; x^2 + y^2 does not change along (y, -x); inputs can be given other values."""

    def outputs(tape: Tape):
        x, y = tape.input("x", 0), tape.input("x", 1)
        return [rate for row in jacobian([x * x + y * y, x * y, sign(x)], [{x: y, y: -x}]) for rate in row]

    program = trace(outputs)
    assert program.operations[program.outputs[0]][:2] == (CONSTANT, 0.0)
    assert program.operations[program.outputs[2]][:2] == (CONSTANT, 0.0)
    assert Multiprecision(program, digits=30)({"x": [[3.0, 5.0]]}, 1)[0][1] == 25 - 9
    product = trace(lambda tape: [tape.input("x", 0) * tape.input("y", 0)])
    assert trace(lambda tape: again(product, tape, {("x", 0): 2.0})).inputs == {("y", 0)}


def test_what_is_not_connected_costs_nothing() -> None:
    """A chain of blocks: of 20 x 20 derivatives 20 are not zero."""
    program = trace(lambda tape: [sin(tape.input("x", i)) for i in range(20)])
    found = derivative(program, [("x", i) for i in range(20)])
    assert found.size == 20
    assert sum(found.operations[k][0] is not CONSTANT for k in found.outputs) == 20


def test_a_row_each_its_own_way() -> None:
    """One output of many inputs goes backwards, many outputs of one input forwards: neither way alone is short."""

    def both(tape: Tape):
        many = sum((tape.input("x", i) for i in range(30)), 0.0)
        one = tape.input("y", 0)
        for _ in range(30):
            many, one = many * sin(many), one * sin(one)
        return [many, *(one * float(k + 2) for k in range(30))]

    program = trace(both)
    inputs = [*(("x", i) for i in range(30)), ("y", 0)]
    assert derivative(program, inputs).size < 8 * program.size


def test_few_calls_for_an_operation() -> None:
    """Of Python and C, for each that is sought on the tape: the first call with a robot waits for all of them."""
    torques = Plan(robot("two_link_spatial"), Scene()).torques()
    found = calls(lambda: derivative(torques, inputs_of({"q": 2, "qd": 2})))
    assert sum(found.values()) < 10 * found[Tape.node.__code__]
