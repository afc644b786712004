"""A tiny program on both executors: whether they work here, how long machine code takes, and whether they agree."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from robodyn.programs.program import Program, trace
from robodyn.programs.run.llvm.machine import Function, compiler, machine_code, one_line
from robodyn.programs.run.numpy_blocks import NumpyBlocks

TOLERANCE = 8 * float(np.finfo(float).eps)
"""Of the largest result: what rounding may make of the few operations."""
_SAMPLES = 1000


@dataclass(frozen=True)
class SelfTest:
    """What became of the program.

    Attributes:
        problem: why there is no machine code; None if there is.
        broken: whether that is a fault, and not what is missing here.
        build, load, run: seconds to compile, to bring to memory, and to run all samples as machine code.
        numpy: seconds to run all samples by NumPy.
        difference: between the results, of the largest.
    """

    problem: str | None
    broken: bool
    numpy: float
    build: float = 0.0
    load: float = 0.0
    run: float = 0.0
    difference: float = 0.0


def self_test() -> SelfTest:
    """Both executors on the same samples; machine code is made anew, whatever is kept."""
    program, widths = _program(), {"x": 2}
    x = np.asfortranarray(np.stack([np.linspace(-3, 3, _SAMPLES), np.linspace(0.1, 2, _SAMPLES)], axis=1))
    by_numpy = NumpyBlocks(program, widths)
    expected, numpy = _timed(lambda: by_numpy({"x": x}, _SAMPLES))
    missing = compiler().problem
    if missing is not None:
        return SelfTest(missing, "does not load" in missing, numpy)
    try:
        from robodyn.programs.run.compiled_blocks import CompiledBlocks, kernel_of

        code, build = _timed(lambda: machine_code(kernel_of(program, widths)))
        _, load = _timed(lambda: Function(code, "kernel"))
        by_code = CompiledBlocks(program, widths)
        found, run = _timed(lambda: by_code({"x": x}, _SAMPLES))
    except (ImportError, OSError, RuntimeError) as error:
        return SelfTest(f"machine code cannot be made ({one_line(error)})", True, numpy)
    difference = float(np.abs(found - expected).max() / np.abs(expected).max())
    wrong = not difference <= TOLERANCE
    problem = f"results differ from NumPy's by {difference:.1e} of the largest" if wrong else None
    return SelfTest(problem, wrong, numpy, build, load, run, difference)


def _program() -> Program:
    def outputs(tape: Any) -> list[Any]:
        angle, length = tape.input("x", 0), tape.input("x", 1)
        return [length * angle.cos(), length * angle.sin() + angle / length, length.sqrt() - angle]

    return trace(outputs)


def _timed(run: Any) -> tuple[Any, float]:
    start = perf_counter()
    result = run()
    return result, perf_counter() - start
