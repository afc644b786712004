"""The compiled executor writes what it should, where it should and nowhere else."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from helpers.array_layouts import LAYOUTS, PROGRAM, expected, ready, state
from helpers.compiled_programs import bits, compiled, needs_compiler

from robodyn.programs.run import compiled_blocks
from robodyn.programs.run.compiled_blocks import BLOCK

pytestmark = needs_compiler


@pytest.fixture(params=["kept in caches", "past the caches"])
def way(request, monkeypatch):
    """How copied results are written: as those of small arrays, and as those of large ones."""
    if request.param == "past the caches":
        monkeypatch.setattr(compiled_blocks, "MOST_STREAMS", 0)
        monkeypatch.setattr(compiled_blocks, "MOST_KEPT", -1)
    return request.param


@pytest.mark.parametrize("layout", [name for name in LAYOUTS if name not in ("other bytes first", "fewer bits")])
def test_output_array_of_any_layout(layout, way, monkeypatch):
    monkeypatch.setattr(compiled_blocks, "THREAD_WORK", 1)
    for samples in (8, 1000):
        arrays = state(samples)
        out = LAYOUTS[layout](np.full((samples, len(PROGRAM.outputs)), -7.0))
        assert ready()(arrays, samples, out, 3) is out
        np.testing.assert_array_equal(bits(out), bits(expected(arrays)))


@pytest.mark.parametrize("step", [1, 2, -1])
@pytest.mark.parametrize("order", "CF")
def test_nothing_beside_the_output_is_written(order, step, way):
    for samples in (1, 9, BLOCK + 5):
        table = np.full((samples * 2 + 40, 20), -7.0, order=order)
        inside = table[20 : 20 + samples * abs(step), 6:12][::step]
        ready()(state(samples), samples, inside)
        assert np.count_nonzero(table == -7.0) == table.size - inside.size
        np.testing.assert_array_equal(bits(inside), bits(expected(state(samples))))


def test_output_over_an_input(monkeypatch):
    """In place, shifted by a sample, and laid across."""
    monkeypatch.setattr(compiled_blocks, "THREAD_WORK", 1)
    samples = 700
    right = bits(expected(state(samples)))
    for shift in (0, -1, 130):
        for order in "CF":
            table = np.zeros((samples + 200, 9), order=order)
            arrays = state(samples)
            arrays["a"] = table[10 : 10 + samples, 2:5]
            arrays["a"][...] = state(samples)["a"]
            out = table[10 + shift : 10 + shift + samples, 1:7] if shift >= 0 else table[9 : 9 + samples, 3:9]
            assert ready()(arrays, samples, out, 2) is out
            np.testing.assert_array_equal(bits(out), right)


@pytest.mark.filterwarnings("error")
def test_numbers_too_large_for_single_precision_warn_as_little_as_others():
    found = compiled(lambda x: [x * 2.0], 1, np.float32)({"x": np.array([[1e300], [-1e300], [3.0]])}, 3)
    np.testing.assert_array_equal(found[:, 0], [np.inf, -np.inf, 6.0])


@pytest.mark.parametrize("layout", ["rows", "both backwards", "unaligned"])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_repeated_outputs_of_any_layout(layout, dtype, way):
    """Each is computed once and copied to wherever it stands, from where it lies."""
    run = compiled(lambda x, y: [x * y, 0.0, x + y, x * y, 0.0, y, x * y, y], 2, dtype)
    x = np.random.default_rng(0).normal(size=(5 * BLOCK + 3, 2)).astype(dtype)
    p, q = x.T
    zeros = np.zeros(len(x))
    expected = np.column_stack((p * q, zeros, p + q, p * q, zeros, q, p * q, q))
    for samples in (1, BLOCK, len(x)):
        out = LAYOUTS[layout](np.full((samples, 8), -7.0, dtype))
        assert run({"x": np.asfortranarray(x[:samples])}, samples, out) is out
        np.testing.assert_array_equal(out, expected[:samples])


def test_no_inputs_no_outputs_no_samples():
    found = compiled(lambda: [2.5, -1.0, 2.5], 0)({}, 300, None, 2)
    np.testing.assert_array_equal(found, np.broadcast_to([2.5, -1.0, 2.5], (300, 3)))
    assert compiled(lambda x: [])({"x": np.zeros((5, 1))}, 5).shape == (5, 0)
    assert ready()(state(0), 0).shape == (0, len(PROGRAM.outputs))
    out = np.empty((0, len(PROGRAM.outputs)))
    assert ready()(state(0), 0, out, 4) is out


GUARDED = """
import ctypes, mmap
import numpy as np
from robodyn.programs.run import compiled_blocks
from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.vectors import sin
from robodyn.programs.program import trace

LIBC, PAGE = ctypes.CDLL(None), mmap.PAGESIZE
keep = []

def placed(samples, columns, order):
    "An array between two pages that may not be touched: the first byte after it, or before it, is forbidden."
    size = samples * columns * 8
    room = -(-size // PAGE) * PAGE
    memory = mmap.mmap(-1, room + 2 * PAGE)
    address = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    for page in (address, address + PAGE + room):
        assert LIBC.mprotect(ctypes.c_void_p(page), PAGE, 0) == 0
    keep.append(memory)
    for first in (PAGE, PAGE + room - size):
        yield np.frombuffer(memory, np.float64, samples * columns, first).reshape((samples, columns), order=order)

compiled_blocks.MOST_STREAMS, compiled_blocks.MOST_KEPT = WAY
run = CompiledBlocks(trace(lambda t: [sin(t.input("x", 0)) * t.input("x", 1), t.input("x", 0)]), {"x": 2})
for samples in (1, 9, 131):
    for order in "CF":
        for x in placed(samples, 2, order):
            x[...] = np.arange(2 * samples).reshape(samples, 2)
            for out in placed(samples, 2, order):
                run({"x": x}, samples, out, 2)
                assert (out[:, 1] == x[:, 0]).all()
print("unharmed")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="needs mprotect")
@pytest.mark.parametrize("limits", ["64, 1 << 22", "0, -1"])
def test_nothing_beside_the_arrays_is_touched(limits):
    done = subprocess.run(
        [sys.executable, "-c", GUARDED.replace("WAY", limits)], check=False, capture_output=True, text=True
    )
    assert done.stdout == "unharmed\n", done.stderr
