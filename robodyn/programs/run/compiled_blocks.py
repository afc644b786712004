"""The `compiled` executor: a program as machine code that works on a vector of samples at a time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.program import Program
from robodyn.programs.run.llvm.build import built
from robodyn.programs.run.llvm.driver import driver
from robodyn.programs.run.llvm.kernel import kernel
from robodyn.programs.run.llvm.machine import Function
from robodyn.programs.run.llvm.team import LINE
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.programs.run.small_batches import FEW, SmallBatches
from robodyn.programs.run.team import Fields, Job
from robodyn.support.threads import cores

SCALARS = {"float64": "double", "float32": "float"}
LANES = {"double": 8, "float": 16}
"""Samples worked on at a time: one register of AVX-512. Half or twice as many were slower or equal, on AVX2 too."""
BLOCK = 128
"""Samples gathered at a time where an array's columns are not contiguous: their rows stay in the first cache."""
LONG_BLOCK = 512
"""Samples at a time of many with contiguous columns: what is copied to many columns is written in long stretches."""
STEP = 8 * BLOCK
"""Samples that a thread takes at a time."""
MOST_STREAMS = 256
"""More columns of results than these are copied to where they belong even where they are contiguous."""
MOST_KEPT = 1 << 22
"""Bytes of results that are written into the caches: more would drive each other out before they are read."""
THREAD_WORK = 1 << 21
"""Operations that are worth a thread of their own: some 50 microseconds."""

Numbers = NDArray[np.floating[Any]]


class CompiledBlocks:
    """A program made ready to run on arrays of samples, as machine code.

    Every sample goes through the same instructions whatever the layout, the number of threads and its neighbours, so
    results depend on none of these. A sample with angles of more than 1.6e6 rad (root of the sum of their squares), or
    with one that is not finite, is left to `NumpyBlocks`.
    """

    def __init__(
        self, program: Program, widths: Mapping[str, int], dtype: Any = np.float64, fused: bool = True
    ) -> None:
        """
        Args:
            widths: how many columns the array of each source will have.
            dtype: float64 or float32, of inputs, results and all operations.
            fused: round products together with the sums that take them in; False rounds each operation, as NumPy does.

        Raises:
            ImportError, OSError, RuntimeError: llvmlite is not there, or does not compile it.
        """
        self.program, self.widths, self.dtype = program, dict(widths), np.dtype(dtype)
        first_row = program.rows(widths)
        self.sources = [source for source in first_row if source]
        self.rows = first_row[""] + len(program.distinct.outputs)
        self._homes = np.array(program.homes, np.int64)
        self._in_order = np.arange(max(self.widths.values(), default=0), dtype=np.int64)
        content = content_of(program, widths, dtype, fused)
        self._kernel = built("kernel", content, lambda: kernel_of(program, widths, dtype, fused))
        self._share = _driver(SCALARS[self.dtype.name])
        self._rooms: list[SmallBatches] = []

    def __call__(
        self, sources: Mapping[str, Numbers], samples: int, out: Numbers | None = None, threads: int | None = 1
    ) -> Numbers:
        """Return the outputs of the program for every sample.

        Args:
            sources: for each source an array (samples, columns), in any layout; contiguous columns are fastest.
            samples: how many.
            out: (samples, outputs) of the executor's dtype, in any layout, written to if given.
            threads: at most so many work at a time, None is all cores; fewer where the work is small.

        Returns:
            (samples, outputs); where `out` is not given each column is contiguous.

        Accuracy: each operation is rounded once, or once with the sum that takes it in; sine, cosine and exponential
        within 1 ulp.
        """
        outputs = len(self.program.outputs)
        result = np.empty((outputs, samples), self.dtype).T if out is None else out
        if samples == 0 or outputs == 0:
            return result
        if samples <= FEW and self._few(sources, samples, result):
            return result
        arrays = [self._plain(name, sources[name], samples) for name in self.sources]
        target = (
            result if out is None or self._fits(out, arrays, samples) else np.empty((outputs, samples), self.dtype).T
        )
        self._bound(arrays, samples, target, cores(threads))()
        if target is not result:
            result[...] = target
        return result

    def _few(self, sources: Mapping[str, Numbers], samples: int, out: Numbers) -> bool:
        """Write the results of few samples; return whether that is done."""
        try:
            # Taken out while it is in use, so that two threads never share it.
            room = self._rooms.pop()
        except IndexError:
            lanes = LANES[SCALARS[self.dtype.name]]
            first_row = self.program.rows(self.widths)
            room = SmallBatches(self._kernel.address, first_row, self.widths, self.rows, self.dtype, lanes, self._homes)
        done = room(sources, samples, out)
        if done:
            self._rooms.append(room)
        return done

    def bound(self, sources: Mapping[str, Numbers], samples: int, out: Numbers) -> Callable[[], None]:
        """`__call__` of one thread with these arguments: to be called often, as what they hold changes.

        Args:
            sources, out: as for `__call__`, of the executor's dtype.
        """
        arrays = [sources[name] for name in self.sources]
        named = zip(self.sources, arrays, strict=True)
        plain = all(self._plain(name, given, samples) is given for name, given in named)
        if not plain or not self._fits(out, arrays, samples):
            raise ValueError("arrays to be used again and again must be of the executor's own numbers, and apart")
        return self._bound(arrays, samples, out, 1)

    def _plain(self, name: str, given: Numbers, samples: int) -> Numbers:
        """Return the array of a source in this machine's own numbers."""
        if given.shape != (samples, self.widths[name]):
            raise ValueError(f"{name} has shape {given.shape}, not {(samples, self.widths[name])}")
        if given.dtype == self.dtype and given.flags.aligned:
            return given
        with np.errstate(all="ignore"):
            return given.astype(self.dtype)

    def _fits(self, out: Numbers, arrays: list[Numbers], samples: int) -> bool:
        """Return whether machine code may write to it."""
        plain = out.dtype == self.dtype and out.flags.behaved and out.shape == (samples, len(self.program.outputs))
        return plain and not any(np.may_share_memory(out, given) for given in arrays)

    def _bound(self, given: list[Numbers], samples: int, out: Numbers, threads: int) -> Callable[[], None]:
        """Return what runs over the samples."""
        few = len(self.program.distinct.outputs) <= MOST_STREAMS
        fields = [*(_fields(each, self._in_order) for each in given), _fields(out, self._homes, few)]
        contiguous = all(each.strides[0] == each.itemsize for each in (*given, out))
        block = LONG_BLOCK if contiguous and samples >= 8 * LONG_BLOCK else BLOCK
        threads = max(1, min(threads, samples * self.program.size // THREAD_WORK, samples // block))
        functions = self._share.address, self._kernel.address
        # No power of two apart, or gathered columns would share sets of the cache.
        pitch = block * self.dtype.itemsize + 8 * LINE
        job = Job(functions, fields, self.rows, pitch, STEP, block, samples, threads)

        def run() -> None:
            if job():
                self._repair(given, samples, out, job.flagged())

        return run

    def _repair(self, arrays: list[Numbers], samples: int, result: Numbers, flagged: NDArray[np.int64]) -> None:
        """Computes the flagged samples by NumPy."""
        chosen = {name: given[flagged] for name, given in zip(self.sources, arrays, strict=True)}
        result[flagged] = self._fallback(chosen, len(flagged))

    @cached_property
    def _fallback(self) -> NumpyBlocks:
        return NumpyBlocks(self.program, self.widths, self.dtype)


def content_of(program: Program, widths: Mapping[str, int], dtype: Any, fused: bool = True) -> object:
    """Return what the machine code of a program depends on."""
    return program.operations, program.distinct.outputs, program.rows(widths), np.dtype(dtype).name, fused


def kernel_of(program: Program, widths: Mapping[str, int], dtype: Any = np.float64, fused: bool = True) -> str:
    """Return the LLVM IR of a program's kernel."""
    scalar = SCALARS[np.dtype(dtype).name]
    return kernel(program.distinct, program.rows(widths), scalar, LANES[scalar], fused)


def _fields(given: Numbers, homes: NDArray[np.int64], few: bool = True) -> Fields:
    """Return what the driver is told of an array."""
    sample_stride, column_stride = given.strides
    direct = few and sample_stride == given.itemsize
    stream = given.nbytes > MOST_KEPT
    return _address(given), _address(homes), sample_stride, column_stride, given.shape[1], direct, stream


def _address(given: NDArray[Any]) -> int:
    return int(given.__array_interface__["data"][0])


@cache
def _driver(scalar: str) -> Function:
    lanes = LANES[scalar]
    return built("share", ("driver", scalar, lanes), lambda: driver(scalar, lanes))
