"""The `compiled` executor: a program as machine code that works on a vector of samples at a time."""

from __future__ import annotations

import ctypes
import os
from array import array
from collections import defaultdict
from collections.abc import Callable, Mapping
from ctypes import c_int64, c_void_p
from functools import cache, cached_property
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.program import Program
from robodyn.programs.run.llvm.build import built
from robodyn.programs.run.llvm.driver import driver
from robodyn.programs.run.llvm.functions import BYTES
from robodyn.programs.run.llvm.kernel import kernel
from robodyn.programs.run.llvm.machine import Function, host
from robodyn.programs.run.numpy_blocks import Numbers, NumpyBlocks
from robodyn.programs.scalar import CONSTANT
from robodyn.support.threads import cores

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor

SCALARS = {"float64": "double", "float32": "float"}
FEW = 16
"""Samples that small batches have room for: some groups of a kernel."""
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
_KERNEL = ctypes.PYFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64)


class CompiledBlocks:
    """A program made ready to run on arrays of samples, as machine code.

    Every sample goes through the same instructions whatever the layout, the number of threads and its neighbours, so
    results depend on none of these. A sample with angles of more than 1.6e6 rad (root of the sum of their squares), or
    with one that is not finite, is left to `NumpyBlocks`.
    """

    def __init__(self, program: Program, widths: Mapping[str, int], dtype: Any = np.float64) -> None:
        """`widths`: of the array of each source; `dtype`: float64 or float32, of inputs, results and all operations.
        ImportError, OSError or RuntimeError where llvmlite is not there, or does not compile it."""
        self.program, self.widths, self.dtype = program, dict(widths), np.dtype(dtype)
        first_row = program.rows(widths)
        self.sources = [source for source in first_row if source]
        self.rows = first_row[""] + len(program.distinct.outputs)
        self.homes = np.array(program.homes, np.int64)
        zeros = [c for c, k in enumerate(program.outputs) if repr(program.operations[k]) == repr((CONSTANT, 0.0, None))]
        self._written = array("q", program.homes), array("q", program.homes)  # to any memory, and to zeros
        for place in zeros[1:]:  # the kernel writes the first
            self._written[1][place] = -1
        self._shared = len(program.homes) > len(program.distinct.outputs)
        self._in_order = array("q", range(max(self.widths.values(), default=0)))
        self.kernel = built("kernel", content_of(program, widths, dtype), lambda: kernel_of(program, widths, dtype))
        scalar = SCALARS[self.dtype.name]
        self.lanes = lanes_of(scalar)
        self.share = _driver(scalar, self.lanes)
        self._few_kernel = _KERNEL(self.kernel.address)
        self._rooms: defaultdict[int, list[Any]] = defaultdict(list)  # by the number of samples

    def __call__(
        self, sources: Mapping[str, Numbers], samples: int, out: Numbers | None = None, threads: int | None = 1
    ) -> Numbers:
        """Return outputs (samples, outputs) for arrays (samples, columns) in any layout, contiguous columns being the
        fastest, written to `out` if given; else each of their columns is contiguous, and what is always zero is not
        written. At most so many threads work at a time, None is all cores; fewer where the work is small. ValueError
        where a source has another shape.

        Accuracy: each operation is rounded once, or once with the sum that takes it in; sine, cosine and exponential
        within 1 ulp.
        """
        outputs = len(self.program.outputs)
        result = np.zeros((outputs, samples), self.dtype).T if out is None else out
        if samples == 0 or outputs == 0:
            return result
        if samples <= FEW and self._few(sources, samples, result):
            return result
        arrays = []
        for name in self.sources:
            given = sources[name]
            if given.shape != (samples, self.widths[name]):
                raise ValueError(f"{name} has shape {given.shape}, not {(samples, self.widths[name])}")
            if given.dtype != self.dtype or not given.flags.aligned:
                with np.errstate(all="ignore"):
                    given = given.astype(self.dtype)
            arrays.append(given)
        target = result
        if out is not None:
            fits = out.dtype == self.dtype and out.flags.behaved and out.shape == (samples, outputs)
            if not fits or any(np.may_share_memory(out, given) for given in arrays):
                target = np.empty((outputs, samples), self.dtype).T
        flagged = self._many(arrays, samples, target, self._written[out is None], cores(threads))
        if len(flagged):
            chosen = {name: given[flagged] for name, given in zip(self.sources, arrays, strict=True)}
            target[flagged] = self._fallback(chosen, len(flagged))
        if target is not result:
            result[...] = target
        return result

    def _few(self, sources: Mapping[str, Numbers], samples: int, out: Numbers) -> bool:
        """Write the results of few samples, unless one is flagged or an array is another; return whether that is done.
        One call of the kernel, which keeps Python's lock: to hand it over and get it back may take longer than the
        work. It sees groups of samples as in any other run, so the results are the same to the bit."""
        rooms = self._rooms[samples]
        try:
            room = rooms.pop()  # taken out while it is in use, so that two threads never share it
        except IndexError:
            room = self._room(samples)
        inputs, outputs, places, _ = room
        for source, rows, shape in inputs:
            given = sources[source]
            if given.shape != shape or given.dtype != self.dtype:
                return False
            rows[...] = given
        if self._few_kernel(*places):
            return False
        out[...] = outputs.take(self.homes, 1) if self._shared else outputs
        rooms.append(room)
        return True

    def _room(self, samples: int) -> tuple[Any, ...]:
        """Return views of rows for all inputs and outputs of few samples, and what the kernel is told of these."""
        memory, flags = np.zeros((self.rows, FEW), self.dtype), np.zeros(FEW, np.uint8)
        table = memory.ctypes.data + memory.strides[0] * np.arange(self.rows)
        places = c_void_p(table.ctypes.data), c_void_p(flags.ctypes.data), -(-samples // self.lanes)
        first_row = self.program.rows(self.widths)
        starts = ((source, first_row[source], self.widths[source]) for source in self.sources)
        inputs = [(source, memory[k : k + width, :samples].T, (samples, width)) for source, k, width in starts]
        return inputs, memory[first_row[""] :, :samples].T, places, (table, flags)

    def _many(
        self, given: list[Numbers], samples: int, out: Numbers, homes: array[int], threads: int
    ) -> NDArray[np.int64]:
        """Write the results of all samples, piece by piece in some threads; return the samples that are flagged."""
        few = len(self.program.distinct.outputs) <= MOST_STREAMS
        fields = [*(_fields(each, self._in_order) for each in given), _fields(out, homes, few)]
        contiguous = all(each.strides[0] == each.itemsize for each in (*given, out))
        block = LONG_BLOCK if contiguous and samples >= 8 * LONG_BLOCK else BLOCK
        threads = max(1, min(threads, samples * self.program.size // THREAD_WORK, samples // block))
        pieces = 1 if threads == 1 else PIECES * threads
        each = -(-samples // (pieces * block)) * block
        table = -(-self.rows // LINE) * 8 * LINE
        pitch = block * self.dtype.itemsize + 8 * LINE  # no power of two, or columns would share sets of the cache
        room = table + self.rows * pitch
        rooms = np.empty(threads * room + 8 * LINE, np.uint8)
        start = _address(rooms)
        aligned, told = start + -start % (8 * LINE), array("q", chain.from_iterable(fields))
        flags = array("B", bytes(-(-samples // block) * block // min(8, self.lanes)))
        places = self.kernel.address, _place(told), aligned, _place(flags)
        job = array("q", (*places, len(fields), room, table, pitch, block))
        flagged, waiting = [], iter(range(0, samples, each))

        def work(me: int) -> None:
            """Take pieces that no other thread has taken, until none is left."""
            for start in waiting:
                if self.share(_place(job), me, start, min(start + each, samples)):
                    flagged.append(start)

        in_pool(work, threads)
        if not flagged:
            return np.empty(0, np.int64)
        bits = np.unpackbits(np.frombuffer(flags, np.uint8), bitorder="little").reshape(-1, max(8, self.lanes))
        return np.asarray(np.flatnonzero(bits[:, : self.lanes].ravel()[:samples]))

    @cached_property
    def _fallback(self) -> NumpyBlocks:
        return NumpyBlocks(self.program, self.widths, self.dtype)


def content_of(program: Program, widths: Mapping[str, int], dtype: Any) -> object:
    """Return what the machine code of a program depends on."""
    return program.operations, program.distinct.outputs, program.rows(widths), np.dtype(dtype).name


def kernel_of(program: Program, widths: Mapping[str, int], dtype: Any = np.float64) -> str:
    scalar = SCALARS[np.dtype(dtype).name]
    return kernel(program.distinct, program.rows(widths), scalar, lanes_of(scalar), pooled=host().pooled)


def lanes_of(scalar: str) -> int:
    """Return how many samples are worked on at a time."""
    return host().vector // BYTES[scalar]


def _fields(given: Numbers, homes: array[int], few: bool = True) -> tuple[int, ...]:
    """Return what the driver is told of an array, as `robodyn.programs.run.llvm.driver.FIELDS` names it."""
    sample_stride, column_stride = given.strides
    direct = few and sample_stride == given.itemsize
    stream = given.nbytes > MOST_KEPT
    return _address(given), _place(homes), sample_stride, column_stride, given.shape[1], direct, stream


def _address(given: NDArray[Any]) -> int:
    return int(given.__array_interface__["data"][0])


def _place(numbers: array[int]) -> int:
    return numbers.buffer_info()[0]


@cache
def _driver(scalar: str, lanes: int) -> Function:
    return built("share", ("driver", scalar, lanes), lambda: driver(scalar, lanes), c_void_p, *[c_int64] * 3)


def in_pool(part: Callable[[int], object], threads: int) -> None:
    """Call part(0), part(1) and so on at a time, the first in this thread; the first leaves nothing for later ones. So
    those that have not begun when it ends need not begin at all: nobody waits for a thread that is late."""
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
