"""The `compiled` executor: a program as machine code that works on a vector of samples at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from ctypes import c_int64, c_void_p
from functools import cache, cached_property
from threading import Thread
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.execute.llvm.build import built
from robodyn.execute.llvm.driver import FIELDS, driver
from robodyn.execute.llvm.kernel import kernel
from robodyn.execute.llvm.machine import Function
from robodyn.execute.numpy_blocks import NumpyBlocks
from robodyn.trace.program import Program

SCALARS = {"float64": "double", "float32": "float"}
LANES = {"double": 8, "float": 16}
"""Samples worked on at a time: one register of AVX-512. Half or twice as many were slower or equal, on AVX2 too."""
BLOCK = 128
"""Samples gathered at a time where an array's columns are not contiguous: their rows stay in the first cache."""
PITCH = BLOCK + 8
"""Numbers from one gathered column to the next: no power of two, or columns would share sets of the cache."""
MOST_STREAMS = 64
"""More columns than these, or more than 8 at distances of whole pages, are gathered even where they are contiguous."""
THREAD_WORK = 1 << 21
"""Operations that are worth a thread of their own: some 50 microseconds."""

Numbers = NDArray[np.floating[Any]]


class CompiledBlocks:
    """A program made ready to run on arrays of samples, as machine code.

    Every sample goes through the same instructions whatever the layout, the number of threads and its neighbours, so
    results depend on none of these. A sample with angles of more than 1.6e6 rad (root of the sum of their squares), or
    with one that is not finite, is left to `NumpyBlocks`.
    """

    def __init__(self, program: Program, widths: Mapping[str, int], dtype: Any = np.float64) -> None:
        """
        Args:
            widths: how many columns the array of each source will have.
            dtype: float64 or float32, of inputs, results and all operations.

        Raises:
            ImportError, OSError: llvmlite is not there.
        """
        self.program, self.widths, self.dtype = program, dict(widths), np.dtype(dtype)
        self.sources, first_row = rows_of(program, widths)
        self.rows = first_row[""] + len(program.outputs)
        scalar = SCALARS[self.dtype.name]
        self._kernel = built(
            "kernel", content_of(program, widths, dtype), lambda: kernel(program, first_row, scalar, LANES[scalar])
        )
        self._run = _driver(scalar)

    def __call__(
        self, sources: Mapping[str, Numbers], samples: int, out: Numbers | None = None, threads: int = 1
    ) -> Numbers:
        """The outputs of the program for every sample.

        Args:
            sources: for each source an array (samples, columns), in any layout; contiguous columns are fastest.
            samples: how many.
            out: (samples, outputs) of the executor's dtype, in any layout, written to if given.
            threads: at most so many work at a time; fewer where the work is small.

        Returns:
            (samples, outputs); where `out` is not given each column is contiguous.

        Accuracy: each operation is rounded once, or once with the sum that takes it in; sine, cosine and exponential
        within 1 ulp.
        """
        outputs = len(self.program.outputs)
        result = np.empty((outputs, samples), self.dtype).T if out is None else out
        if samples == 0 or outputs == 0:
            return result
        arrays = [self._plain(sources[name]) for name in self.sources]
        target = result
        if out is not None and (not out.flags.aligned or any(np.may_share_memory(out, array) for array in arrays)):
            target = np.empty((outputs, samples), self.dtype).T
        flags = np.empty(-(-samples // BLOCK) * BLOCK // 8, np.uint8)
        if self._in_threads([*arrays, target], flags, samples, threads):
            self._repair(sources, samples, target, flags)
        if target is not result:
            result[...] = target
        return result

    def _plain(self, array: Numbers) -> Numbers:
        """The array in this machine's own numbers."""
        return array if array.dtype == self.dtype and array.flags.aligned else array.astype(self.dtype)

    def _in_threads(self, arrays: Sequence[Numbers], flags: NDArray[np.uint8], samples: int, threads: int) -> bool:
        """Runs over consecutive parts of the samples; whether any sample is flagged."""
        threads = max(1, min(threads, samples * max(self.program.size, 1) // THREAD_WORK, samples // BLOCK))
        each = -(-samples // (threads * BLOCK)) * BLOCK
        parts = [slice(start, min(start + each, samples)) for start in range(0, samples, each)]
        found: list[int] = []

        def work(part: slice) -> None:
            found.append(
                self._part([array[part] for array in arrays], flags[part.start // 8 :], part.stop - part.start)
            )

        others = [Thread(target=work, args=(part,)) for part in parts[1:]]
        for thread in others:
            thread.start()
        work(parts[0])
        for thread in others:
            thread.join()
        if len(found) < len(parts):
            raise MemoryError("a thread of the compiled executor ended early")
        return any(found)

    def _part(self, arrays: Sequence[Numbers], flags: NDArray[np.uint8], samples: int) -> int:
        table = np.empty(self.rows, np.int64)
        work = np.empty((self.rows, PITCH), self.dtype)
        fields = np.array([_fields(array, self.rows <= MOST_STREAMS) for array in arrays], np.int64)
        return self._run(
            self._kernel.address,
            fields.ctypes.data,
            len(arrays),
            table.ctypes.data,
            work.ctypes.data,
            work.strides[0],
            flags.ctypes.data,
            samples,
            BLOCK,
        )

    def _repair(self, sources: Mapping[str, Numbers], samples: int, result: Numbers, flags: NDArray[np.uint8]) -> None:
        """Computes the flagged samples by NumPy."""
        flagged = np.flatnonzero(np.unpackbits(flags, bitorder="little")[:samples])
        chosen = {name: sources[name][flagged] for name in self.sources}
        result[flagged] = self._fallback(chosen, len(flagged))

    @cached_property
    def _fallback(self) -> NumpyBlocks:
        return NumpyBlocks(self.program, self.widths, self.dtype)


def rows_of(program: Program, widths: Mapping[str, int]) -> tuple[list[str], dict[str, int]]:
    """The sources that a program reads, and the first row of each; the outputs, named "", come last."""
    sources = sorted({source for source, _ in program.inputs})
    first_row, row = {}, 0
    for source in sources:
        first_row[source] = row
        row += widths[source]
    return sources, {**first_row, "": row}


def content_of(program: Program, widths: Mapping[str, int], dtype: Any) -> object:
    """What the machine code of a program depends on."""
    return program.operations, program.outputs, rows_of(program, widths)[1], np.dtype(dtype).name


def _fields(array: Numbers, few: bool) -> tuple[int, ...]:
    """What the driver is told of an array (`FIELDS`)."""
    columns = array.shape[1]
    apart = columns <= 8 or array.strides[1] % 4096 != 0
    direct = few and apart and array.strides[0] == array.itemsize
    fields = (array.ctypes.data, array.strides[0], array.strides[1], columns, int(direct))
    assert len(fields) == len(FIELDS)
    return fields


@cache
def _driver(scalar: str) -> Function:
    whole, pointer = c_int64, c_void_p
    return built(
        "run",
        ("driver", scalar, LANES[scalar]),
        lambda: driver(scalar, LANES[scalar]),
        *(whole, pointer, whole, pointer, pointer, whole, pointer, whole, whole),
    )
