"""The numpy executor: the same bits whatever the block size, the layout and the number of samples."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.array_layouts import LAYOUTS
from helpers.oracles import golden_model, random_state

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.dynamics.plan import Plan
from robodyn.programs.program import trace
from robodyn.programs.run import numpy_blocks
from robodyn.programs.run.numpy_blocks import LARGEST, NumpyBlocks
from robodyn.programs.vectors import exp, sign
from robodyn.scene.scene import Scene

MODEL = golden_model("puma560_corke")
WIDTHS = {"q": 6, "qd": 6, "qdd": 6}
PROGRAM = Plan(MODEL, Scene()).torques()


def _state(samples, seed=8):
    return dict(zip(WIDTHS, random_state(MODEL, np.random.default_rng(seed), samples), strict=True))


@pytest.mark.parametrize("layout", LAYOUTS)
def test_layout_changes_no_bit(layout):
    state = _state(77)
    for values in state.values():
        values.flags.writeable = False
    other = {name: LAYOUTS[layout](values) for name, values in state.items()}
    expected = NumpyBlocks(PROGRAM, WIDTHS)({name: values.astype(float) for name, values in other.items()}, 77)
    np.testing.assert_array_equal(NumpyBlocks(PROGRAM, WIDTHS)(other, 77), expected)
    np.testing.assert_array_equal(inverse_dynamics(MODEL, *other.values(), executor="numpy"), expected)


def test_no_samples_and_output_arrays_of_any_layout():
    assert inverse_dynamics(MODEL, np.empty((0, 6)), np.empty((0, 6)), np.empty((0, 6))).shape == (0, 6)
    state = _state(24)
    expected = NumpyBlocks(PROGRAM, WIDTHS)(state, 24)
    for out in (np.full((24, 6), np.nan, order="C"), np.full((24, 6), np.nan, order="F")):
        assert NumpyBlocks(PROGRAM, WIDTHS)(state, 24, out) is out
        np.testing.assert_array_equal(out, expected)
    cube = np.full((6, 2, 3, 8), np.nan).T[::2]
    shaped = [values.reshape(4, 3, 2, 6) for values in state.values()]
    assert inverse_dynamics(MODEL, *shaped, out=cube) is cube
    np.testing.assert_array_equal(cube, expected.reshape(4, 3, 2, 6))


def test_inputs_broadcast():
    state = _state(12)
    expected = inverse_dynamics(MODEL, state["q"], np.zeros((12, 6)), state["qdd"])
    np.testing.assert_array_equal(inverse_dynamics(MODEL, state["q"], 0, state["qdd"]), expected)
    one = inverse_dynamics(MODEL, state["q"][0], state["qd"][:, None], state["qdd"])
    assert one.shape == (12, 12, 6)
    single = inverse_dynamics(MODEL, state["q"][0], state["qd"][5], state["qdd"][7])
    np.testing.assert_array_equal(one[5, 7], single)


def test_outputs_that_are_inputs_constants_or_repeated():
    def outputs(tape):
        x, y = tape.input("q", 0), tape.input("q", 1)
        total = x + y
        return [total, 2.5, x, total, total * x, 0.0, -y, exp(sign(y))]

    q = np.array([[1.0, 2.0], [-3.0, 0.0], [0.5, -4.0]])
    found = NumpyBlocks(trace(outputs), {"q": 2})({"q": q}, 3)
    x, y = q.T
    expected = [x + y, np.full(3, 2.5), x, x + y, (x + y) * x, np.zeros(3), -y, np.exp(np.sign(y))]
    np.testing.assert_array_equal(found, np.column_stack(expected))


def test_rows_are_reused():
    """A long chain of operations needs few rows, and blocks shrink as programs need more."""

    def chain(tape):
        x = tape.input("q", 0)
        for k in range(1000):
            x = (x + float(k)) * 0.5
        return [x]

    runner = NumpyBlocks(trace(chain), {"q": 1})
    assert runner.rows <= 4
    assert runner.block == numpy_blocks.LARGEST
    rows = NumpyBlocks(PROGRAM, WIDTHS).rows
    assert rows < PROGRAM.size / 4


@pytest.mark.parametrize("shift", [-100, 0, 100])
def test_output_over_an_input(shift):
    """More samples than a block holds, written some rows from where they are read."""
    samples = 3 * LARGEST
    memory = np.linspace(-3.0, 3.0, samples + 200)[:, None]
    program = trace(lambda tape: [tape.input("q", 0) * 2.0 + 1.0])
    given, out = memory[100 : 100 + samples], memory[100 + shift : 100 + shift + samples]
    expected = given * 2.0 + 1.0
    assert NumpyBlocks(program, {"q": 1})({"q": given}, samples, out) is out
    np.testing.assert_array_equal(out, expected)
