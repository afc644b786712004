"""The `numpy` executor: a program as straight-line NumPy over blocks of samples that stay in the cache."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.program import Program
from robodyn.programs.scalar import ADD, CONSTANT, COS, DIV, EXP, INPUT, MUL, NEG, SIGN, SIN, SQRT, SUB

Numbers = NDArray[np.floating[Any]]

COPY = "copy"
UFUNCS: dict[str, Any] = {
    ADD: np.add,
    SUB: np.subtract,
    MUL: np.multiply,
    DIV: np.divide,
    NEG: np.negative,
    SQRT: np.sqrt,
    SIN: np.sin,
    COS: np.cos,
    SIGN: np.sign,
    EXP: np.exp,
    COPY: np.positive,
}

CACHE_BYTES = 8 << 20
"""The rows of one block may fill this much: the last-level cache of a small machine."""
SMALLEST, LARGEST = 256, 4096
"""Samples per block: enough to hide NumPy's cost per call, few enough to stay near the core."""


class NumpyBlocks:
    """A program made ready to run on arrays of samples. The workspace has a row per output, then a row per column of
    every source, then rows for what lies between, each reused as soon as its value has been used for the last time, so
    that a block of samples stays in the cache. The last workspace is kept for the next call."""

    def __init__(self, program: Program, widths: Mapping[str, int], dtype: Any = np.float64) -> None:
        """`widths`: of the array of each source; `dtype`: float64 or float32, of inputs, results and all operations."""
        self.dtype: np.dtype[Any] = np.dtype(dtype)
        self.outputs = len(program.outputs)
        self.first_row = program.rows(widths, self.outputs)
        self.steps, self.constants, self.rows = _allocated(program, self.first_row, self.first_row.pop(""))
        fitting: int = CACHE_BYTES // (self.dtype.itemsize * max(self.rows, 1)) // 8 * 8
        self.block = min(max(fitting, SMALLEST), LARGEST)
        self._ready: dict[int, tuple[Numbers, list[tuple[Any, tuple[Any, ...]]]]] = {}

    def __call__(self, sources: Mapping[str, Numbers], samples: int, out: Numbers | None = None) -> Numbers:
        """Return outputs (samples, outputs) for arrays (samples, columns) of any layout, written to `out` if given,
        else with contiguous columns.

        Accuracy: each operation is rounded once; sine, cosine and exponential are NumPy's (within 1 ulp in float64,
        3 in float32).
        """
        if out is not None and any(np.may_share_memory(out, sources[source]) for source in self.first_row):
            out[...] = self(sources, samples)
            return out
        result = np.empty((self.outputs, samples), self.dtype).T if out is None else out
        if samples == 0:
            return result
        # all that fit, or blocks of nearly equal size, one of few sizes so that they are ready
        size = -(-samples // -(-samples // self.block))
        if size > SMALLEST:
            size = min(-(-size // SMALLEST) * SMALLEST, max(self.block, size))
        with np.errstate(all="ignore"):
            # Taken out while it is in use, so that two threads never share a workspace.
            ready = self._ready.pop(size, None) or self._prepared(size)
            rows, steps = ready
            for start in range(0, samples, size):
                block = slice(start, min(start + size, samples))
                filled = block.stop - start
                for source, first in self.first_row.items():
                    columns = sources[source][block].T
                    rows[first : first + len(columns), :filled] = columns
                for ufunc, args in steps:
                    ufunc(*args)
                result[block] = rows[: self.outputs, :filled].T
        self._ready.clear()
        self._ready[size] = ready
        return result

    def _prepared(self, size: int) -> tuple[Numbers, list[tuple[Any, tuple[Any, ...]]]]:
        """Return a workspace for blocks of `size` samples, and the calls that fill it. Its rows start on cache lines,
        and their stride is no power of two (they would share sets of the cache)."""
        line = 64 // self.dtype.itemsize
        stride = -(-size // line) * line + line
        raw = np.ones(self.rows * stride + line, self.dtype)
        first = -(raw.ctypes.data // self.dtype.itemsize) % line
        rows = raw[first : first + self.rows * stride].reshape(self.rows, stride)[:, :size]
        # one view of each row, whoever uses it; constants from the end on
        all_rows = [*rows, *(np.array(number).astype(self.dtype) for number in reversed(self.constants))]
        return rows, [(UFUNCS[op], tuple(map(all_rows.__getitem__, places))) for op, places in self.steps]


def _allocated(
    program: Program, first_row: Mapping[str, int], row: int
) -> tuple[list[tuple[str, tuple[int, ...]]], list[float], int]:
    """Return each operation with the rows of its operands and of its result; constants, the first of which is row -1;
    and how many rows of the workspace are needed; those below `row` are taken."""
    home = {position: place for place, position in reversed(list(enumerate(program.outputs)))}
    last_use = [0] * len(program.operations)
    for k, (op, a, b) in enumerate(program.operations):
        if op is not INPUT and op is not CONSTANT:
            last_use[a] = last_use[a if b is None else b] = k
    temporary, steps = row, list[tuple[str, tuple[int, ...]]]()
    constants: list[float] = []
    where: list[int] = []
    free: list[int] = []
    for k, (op, a, b) in enumerate(program.operations):
        if op is INPUT:
            where.append(first_row[a] + b)
        elif op is CONSTANT:
            constants.append(a)
            where.append(-len(constants))
        else:
            for arg in (a,) if b is None or b == a else (a, b):
                if last_use[arg] == k and where[arg] >= temporary:
                    free.append(where[arg])
            if k in home:
                target = home[k]
            elif free:
                target = free.pop()
            else:
                target, row = row, row + 1
            where.append(target)
            steps.append((op, (where[a], target) if b is None else (where[a], where[b], target)))
    copies = ((COPY, (where[position], place)) for place, position in enumerate(program.outputs))
    return [*steps, *(step for step in copies if step[1][0] != step[1][1])], constants, row
