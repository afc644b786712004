"""Small programs for the compiled executor."""

from __future__ import annotations

import numpy as np
import pytest

from robodyn.programs.program import trace
from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.run.llvm.machine import compiler_problem

needs_compiler = pytest.mark.skipif(compiler_problem() is not None, reason=str(compiler_problem()))


def program_of(function, inputs):
    """The program of a function from so many scalars, the columns of the source `x`, to a list of them."""
    return trace(lambda tape: function(*(tape.input("x", i) for i in range(inputs))))


def compiled(function, inputs=1, dtype=np.float64):
    return CompiledBlocks(program_of(function, inputs), {"x": inputs}, dtype)


def bits(array):
    """The numbers as integers, so that comparing them tells zeros and NaNs apart."""
    whole = np.ascontiguousarray(array)
    return whole.view(f"i{whole.itemsize}")
