"""Room in which a kernel works on few samples, kept ready from call to call."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

FEW = 16
"""Samples that there is room for: one or two groups of a kernel."""

Numbers = NDArray[np.floating[Any]]
_KERNEL = ctypes.PYFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64)


class _Parts(NamedTuple):
    """The parts of the rows that some number of samples fill."""

    inputs: Sequence[tuple[str, Numbers, tuple[int, ...]]]
    outputs: Numbers


class SmallBatches:
    """Rows for the columns of all sources and for the outputs, and the kernel's call on them.

    For one call at a time. The kernel sees groups of samples as in any other run, so the results are the same to the
    bit; Python's lock is kept, for to hand it over and get it back may take longer than the work.
    """

    def __init__(
        self,
        kernel: int,
        first_row: Mapping[str, int],
        widths: Mapping[str, int],
        rows: int,
        dtype: Any,
        lanes: int,
        homes: NDArray[np.int64],
    ) -> None:
        """
        Args:
            kernel: the address of what `robodyn.programs.run.llvm.kernel` writes.
            first_row: where the rows of each source begin, and under "" those of the outputs.
            widths: how many columns the array of each source has.
            rows: of all sources and outputs.
            lanes: samples in a group.
            homes: the row of each output, from the first of them on.
        """
        memory, first = np.zeros((rows, FEW), dtype), first_row[""]
        self._table = memory.ctypes.data + memory.strides[0] * np.repeat(np.arange(rows), 2)  # no memory ahead
        self._flags = np.zeros(FEW // 8, np.uint8)
        self._places = ctypes.c_void_p(self._table.ctypes.data), ctypes.c_void_p(self._flags.ctypes.data)
        self._kernel, self._lanes, self._dtype = _KERNEL(kernel), lanes, memory.dtype
        starts = ((source, start, widths[source]) for source, start in first_row.items() if source)
        self._inputs = [(source, memory[start : start + width].T) for source, start, width in starts]
        self._outputs = memory[first:].T
        self._homes = homes if len(homes) > rows - first else None  # None: each row is one output, in their order
        self._parts: dict[int, _Parts] = {}

    def __call__(self, sources: Mapping[str, Numbers], samples: int, out: Numbers) -> bool:
        """Write the outputs of up to FEW samples to `out`, which may overlap the sources.

        Returns:
            Whether that is done; if not, an array is of other numbers, or a sample is flagged, and this is to be used
            no more.

        Raises:
            ValueError: a source has another shape than (samples, width).
        """
        inputs, outputs = self._parts.get(samples) or self._part(samples)
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

    def _part(self, samples: int) -> _Parts:
        """Return what so many samples fill."""
        inputs = [(source, rows[:samples], (samples, rows.shape[1])) for source, rows in self._inputs]
        parts = _Parts(inputs, self._outputs[:samples])
        return self._parts.setdefault(samples, parts)
