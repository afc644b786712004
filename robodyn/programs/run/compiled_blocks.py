"""The `compiled` executor: a program as machine code that works on a vector of samples at a time."""

from __future__ import annotations

import ctypes
import os
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from ctypes import c_int64, c_void_p
from functools import cache, cached_property, partial
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.program import Program
from robodyn.programs.run.llvm.build import built
from robodyn.programs.run.llvm.driver import driver
from robodyn.programs.run.llvm.kernel import kernel
from robodyn.programs.run.llvm.machine import Function
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.support.threads import cores

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor

SCALARS = {"float64": "double", "float32": "float"}
LANES = {"double": 8, "float": 16}
"""Samples worked on at a time: one register of AVX-512. Half or twice as many were slower or equal, on AVX2 too."""
FEW = 16
"""Samples that small batches have room for: one or two groups of a kernel."""
BLOCK = 128
"""Samples gathered at a time where an array's columns are not contiguous: their rows stay in the first cache."""
LONG_BLOCK = 512
"""Samples at a time of many with contiguous columns: what is copied to many columns is written in long stretches."""
PIECES = 4
"""For each thread, which takes one after another: none waits long for another that began late."""
MOST_STREAMS = 256
"""More columns of results than these are copied to where they belong even where they are contiguous."""
MOST_KEPT = 1 << 22
"""Bytes of results that are written into the caches: more would drive each other out before they are read."""
THREAD_WORK = 1 << 21
"""Operations that are worth a thread of their own: some 50 microseconds."""

LINE = 8
"""Numbers of 64 bits in a line of the cache."""

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
        self.homes = np.array(program.homes, np.int64)
        self._in_order = np.arange(max(self.widths.values(), default=0), dtype=np.int64)
        content = content_of(program, widths, dtype, fused)
        self.kernel = built("kernel", content, lambda: kernel_of(program, widths, dtype, fused))
        self.share = _driver(SCALARS[self.dtype.name])
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
            room = SmallBatches(self)
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
        fields = [*(_fields(each, self._in_order) for each in given), _fields(out, self.homes, few)]
        contiguous = all(each.strides[0] == each.itemsize for each in (*given, out))
        block = LONG_BLOCK if contiguous and samples >= 8 * LONG_BLOCK else BLOCK
        threads = max(1, min(threads, samples * self.program.size // THREAD_WORK, samples // block))
        job = Job(self, fields, block, samples, threads)

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
    return built("share", ("driver", scalar, lanes), lambda: driver(scalar, lanes), c_void_p, *[c_int64] * 3)


_KERNEL = ctypes.PYFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64)


class SmallBatches:
    """Room in which a kernel works on few samples, kept ready from call to call: rows for all sources and outputs.

    For one call at a time. The kernel sees groups of samples as in any other run, so the results are the same to the
    bit; Python's lock is kept, for to hand it over and get it back may take longer than the work.
    """

    def __init__(self, of: CompiledBlocks) -> None:
        first_row, homes = of.program.rows(of.widths), of.homes
        memory, first = np.zeros((of.rows, FEW), of.dtype), first_row[""]
        self._table = memory.ctypes.data + memory.strides[0] * np.repeat(np.arange(of.rows), 2)  # no memory ahead
        self._flags = np.zeros(FEW // 8, np.uint8)
        self._places = c_void_p(self._table.ctypes.data), c_void_p(self._flags.ctypes.data)
        self._kernel, self._dtype = _KERNEL(of.kernel.address), memory.dtype
        self._lanes = LANES[SCALARS[of.dtype.name]]
        starts = ((source, start, of.widths[source]) for source, start in first_row.items() if source)
        self._inputs = [(source, memory[start : start + width].T) for source, start, width in starts]
        self._outputs = memory[first:].T
        self._homes = homes if len(homes) > of.rows - first else None  # None: each row is one output, in their order
        self._parts: dict[int, tuple[list[Any], Numbers]] = {}

    def __call__(self, sources: Mapping[str, Numbers], samples: int, out: Numbers) -> bool:
        """Write the outputs of up to FEW samples to `out`, which may overlap the sources.

        Returns:
            Whether that is done; if not, an array is of other numbers, or a sample is flagged, and this is to be used
            no more.

        Raises:
            ValueError: a source has another shape than (samples, width).
        """
        if samples not in self._parts:
            parts = [(source, rows[:samples], (samples, rows.shape[1])) for source, rows in self._inputs]
            self._parts[samples] = parts, self._outputs[:samples]
        inputs, outputs = self._parts[samples]
        for source, rows, shape in inputs:
            given = sources[source]
            if given.shape != shape:
                raise ValueError(f"{source} has shape {given.shape}, not {shape}")
            if given.dtype != self._dtype:
                return False
            rows[...] = given
        if self._kernel(*self._places, -(-samples // self._lanes)):
            return False
        out[...] = outputs if self._homes is None else outputs.take(self._homes, 1)
        return True


Fields = tuple[int, int, int, int, int, bool, bool]
"""Of an array, as `robodyn.programs.run.llvm.driver.FIELDS` names them."""


class Job:
    """A run of machine code over all samples of some arrays, which may be repeated as what they hold changes."""

    def __init__(self, of: CompiledBlocks, fields: Sequence[Fields], block: int, samples: int, threads: int) -> None:
        """Args: fields: of the arrays, which the caller keeps; the last is written to. block: samples of a block."""
        self._samples, self._share, self._threads, self._flagged = samples, of.share, threads, False
        self._flags = array("B", bytes(-(-samples // block) * block // 8))
        pieces = 1 if threads == 1 else PIECES * threads
        self._each = -(-samples // (pieces * block)) * block
        self._fields = array("q", chain.from_iterable(fields))
        table = -(-2 * of.rows // LINE) * 8 * LINE
        pitch = block * of.dtype.itemsize + 8 * LINE  # no power of two, or columns would share sets of the cache
        room = table + of.rows * pitch
        self._rooms = np.empty(threads * room + 8 * LINE, np.uint8)
        rooms = int(self._rooms.__array_interface__["data"][0])
        rooms += -rooms % (8 * LINE)
        places = (of.kernel.address, _place(self._fields), rooms, _place(self._flags))
        self._job = array("q", (*places, len(fields), room, table, pitch, block))

    def __call__(self) -> bool:
        """Run; whether a sample is flagged."""
        self._flagged = False
        in_pool(partial(self._work, iter(range(0, self._samples, self._each))), self._threads)
        return self._flagged

    def _work(self, waiting: Iterator[int], me: int) -> None:
        """Take pieces that no other thread has taken, until none is left."""
        for start in waiting:
            if self._share(_place(self._job), me, start, min(start + self._each, self._samples)):
                self._flagged = True

    def flagged(self) -> NDArray[np.int64]:
        """Return the samples that are flagged; every run writes all flags anew."""
        flags = np.unpackbits(np.frombuffer(self._flags, np.uint8), bitorder="little")
        found: NDArray[np.int64] = np.flatnonzero(flags[: self._samples])
        return found


def _place(numbers: array[int]) -> int:
    return numbers.buffer_info()[0]


def in_pool(part: Callable[[int], object], threads: int) -> None:
    """Call part(0), part(1) and so on at a time, the first in this thread; the first leaves nothing for later ones.

    So those that have not begun when it ends need not begin at all: nobody waits for a thread that is late.
    """
    others = [_pool(os.getpid()).submit(part, number) for number in range(1, threads)]
    try:
        part(0)
    finally:
        for other in others:
            if not other.cancel():
                other.result()


@cache
def _pool(process: int) -> ThreadPoolExecutor:
    """Return the threads of a process; a fork, another process, has its own."""
    from concurrent.futures import ThreadPoolExecutor

    return ThreadPoolExecutor(cores(), thread_name_prefix="robodyn")
