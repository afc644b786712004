"""How kernels reach memory: what they call for before it is wanted, and registers that are put by in whole lines."""

from __future__ import annotations

import re
from ctypes import CFUNCTYPE, POINTER, c_int64, c_void_p
from types import SimpleNamespace

import numpy as np
import pytest
from helpers.compiled_programs import needs_compiler, program_of
from helpers.oracles import golden_model

from robodyn.dynamics.plan import Plan
from robodyn.programs.run import compiled_blocks
from robodyn.programs.run.compiled_blocks import BLOCK, CompiledBlocks, kernel_of
from robodyn.programs.run.llvm.driver import AHEAD
from robodyn.programs.run.llvm.machine import _target_machine, host
from robodyn.scene.scene import Scene

pytestmark = needs_compiler

COLUMNS, SAMPLES = 3, 5 * BLOCK


@pytest.fixture
def tables():
    """What kernels are told, block by block: of each column, where its numbers are and what to call for."""
    told, kept = [], []

    @CFUNCTYPE(c_int64, POINTER(c_int64), c_void_p, c_int64)
    def kernel(rows, flags, groups):
        told.append(np.array(rows[: 4 * COLUMNS]).reshape(-1, 2))
        return 0

    class Told(CompiledBlocks):
        def __call__(self, *given):
            kept.append(kernel)
            self.kernel = SimpleNamespace(address=c_int64.from_buffer(kernel).value)
            return super().__call__(*given)

    program = program_of(lambda *x: [-each for each in x], COLUMNS)

    def run(x, out):
        Told(program, {"x": COLUMNS})({"x": x}, SAMPLES, out)
        return told

    return run


@pytest.mark.parametrize("past", [False, True], ids=["kept in caches", "past the caches"])
def test_columns_are_called_for_as_they_lie(tables, monkeypatch, past):
    """Results that pass the caches are not called for."""
    if past:
        monkeypatch.setattr(compiled_blocks, "MOST_STREAMS", 0)
        monkeypatch.setattr(compiled_blocks, "MOST_KEPT", -1)
    x, out = np.zeros((COLUMNS, SAMPLES)).T, np.zeros((COLUMNS, SAMPLES)).T
    blocks = tables(x, out)
    for told in blocks:
        np.testing.assert_array_equal(told[:COLUMNS, 1], told[:COLUMNS, 0] + AHEAD)
        np.testing.assert_array_equal(told[COLUMNS:, 1], told[COLUMNS:, 0] + (0 if past else AHEAD))
    assert len(blocks) == SAMPLES // BLOCK


def test_rows_are_called_for_a_block_ahead(tables):
    """Together the columns that a kernel calls for are the rows of the next block, each number once."""
    x, out = np.zeros((SAMPLES, COLUMNS)), np.zeros((SAMPLES, COLUMNS))
    for block, told in enumerate(tables(x, out)):
        for array, part in ((x, told[:COLUMNS]), (out, told[COLUMNS:])):
            called = (part[:, 1:] + 8 * np.arange(BLOCK)).ravel()
            following = array.ctypes.data + 8 * (block + 1) * BLOCK * COLUMNS
            np.testing.assert_array_equal(np.sort(called), following + 8 * np.arange(BLOCK * COLUMNS))
            assert (part[:, 0] % 64 == 0).all()


@pytest.mark.skipif(not host().triple.startswith("x86_64"), reason="reads assembly of x86-64")
def test_registers_are_put_by_in_whole_lines():
    """A vector on the stack that crosses a line of the cache costs twice."""
    import llvmlite.binding as llvm

    model = golden_model("tree15_bf2_skew0.3")
    ir = kernel_of(Plan(model, Scene()).torques(), {"q": model.nq, "qd": model.n, "qdd": model.n})
    assembly = _target_machine().emit_assembly(llvm.parse_assembly(ir))
    size = 64 if "zmm" in assembly else 32
    offsets = re.findall(r"v\w+.*?(-?\d*)\(%rsp\).*%[zy]mm|v\w+.*%[zy]mm\d+, (-?\d*)\(%rsp\)", assembly)
    assert f"andq\t$-{size}, %rsp" in assembly
    assert len(offsets) > 100
    assert all(int(a or b or 0) % size == 0 for a, b in offsets)
