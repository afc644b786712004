"""Programs that are repeated, each run from the results of the one before: in machine code, or by NumPy."""

from __future__ import annotations

from ctypes import addressof, c_int64, c_void_p
from functools import cache
from typing import NamedTuple

import numpy as np

from robodyn.programs.program import Program
from robodyn.programs.run.llvm.build import built
from robodyn.programs.run.llvm.kernel import kernel
from robodyn.programs.run.llvm.machine import Function
from robodyn.programs.run.llvm.rollout import DONE, NEAR, rollout
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.support.floats import Floats

LANES = 8
"""Rollouts worked on at a time."""
COLUMNS = "columns"
"""The source of programs whose values are given for each step."""
SINGLE = 1
"""Lanes for one rollout: a step waits for its divisions and roots, which are quicker one by one."""
SWEEPS = 60
"""At most so many sweeps of an implicit step."""


class Done(NamedTuple):
    """How far a run came.

    Attributes:
        steps: that were done.
        settled: whether it is not sweeps that failed.
        sweeps: of all steps, if they are done.
    """

    steps: int
    settled: bool
    sweeps: int = 0


class CompiledSteps:
    """The programs of a step, repeated in machine code on some rollouts at a time."""

    def __init__(
        self, source: str, width: int, step: Program, sweep: Program | None, lanes: int, columns: int = 0
    ) -> None:
        """
        Args:
            source: the name of the source of both programs that has `width` columns.
            step: a program of `width` outputs.
            sweep: None, or a program with a further output, its change.
            columns: of COLUMNS, the other source, which the programs find anew at each step.

        Raises:
            ImportError, OSError, RuntimeError: llvmlite is not there, or does not compile them.
        """
        self.width, self.lanes, self.columns = width, lanes, columns
        self._step = _kernel(step, source, width, lanes, columns)
        self._sweep = None if sweep is None else _kernel(sweep, source, width, lanes, columns)
        self._run = _rollout(lanes)

    def __call__(self, slots: Floats, every: int, columns: Floats | None = None) -> Done:
        """Fills the slots from the first on.

        Args:
            slots: (records + 1, width, rollouts), contiguous; a multiple of `lanes` rollouts.
            every: steps from one record to the next.
            columns: (steps, columns) that all rollouts are given; None where there are none.
        """
        records, width, samples = len(slots) - 1, *slots.shape[1:]
        spare = np.empty((4, width + 1, samples))
        table, flags = np.empty(2 * width + 1 + self.columns, np.int64), np.zeros(samples, np.uint8)
        given = np.empty(0) if columns is None else np.repeat(columns[:, :, None], samples, axis=2)
        kernels = 0 if self._sweep is None else self._sweep.address, self._step.address
        places = (array.ctypes.data for array in (slots, spare, table, flags))
        swept = c_int64(0)
        sizes = width, 8 * samples, samples // self.lanes, records, every, SWEEPS
        done = self._run(*kernels, *places, *sizes, given.ctypes.data, self.columns, addressof(swept))
        return Done(done, True, swept.value) if done >= 0 else Done(-1 - done, False)


class NumpySteps:
    """The same by NumPy, one call per operation and step."""

    def __init__(self, source: str, width: int, step: Program, sweep: Program | None, columns: int = 0) -> None:
        """Args: as for `CompiledSteps`."""
        self.source, self.width, self.lanes, self.columns = source, width, 1, columns
        widths = {source: width, COLUMNS: columns}
        self._step = NumpyBlocks(step, widths)
        self._sweep = None if sweep is None else NumpyBlocks(sweep, widths)

    def __call__(self, slots: Floats, every: int, columns: Floats | None = None) -> Done:
        """As `CompiledSteps`."""
        state, sweeps = slots[0].T, 0
        for k in range(every * (len(slots) - 1)):
            now = np.empty((len(state), 0)) if columns is None else np.repeat(columns[k : k + 1], len(state), axis=0)
            if self._sweep is not None:
                found, count = self._settled(self._sweep, state, now)
                if found is None:
                    return Done(k, False)
                state, sweeps = found, sweeps + count
            state = np.asarray(self._step({self.source: state, COLUMNS: now}, len(state)), dtype=float)
            if not np.isfinite(state).all():
                return Done(k, True)
            if (k + 1) % every == 0:
                slots[(k + 1) // every] = state.T
        return Done(every * (len(slots) - 1), True, sweeps)

    def _settled(self, sweep: NumpyBlocks, state: Floats, now: Floats) -> tuple[Floats | None, int]:
        """Return what sweeps end with, None if they do not, and how many it took."""
        before = np.inf
        for count in range(1, SWEEPS + 1):
            swept = sweep({self.source: state, COLUMNS: now}, len(state))
            state, change = np.asarray(swept[:, :-1], dtype=float), float(swept[:, -1].max())
            if change <= DONE or (change <= NEAR and change >= before):
                return state, count
            before = change
        return None, SWEEPS


def _kernel(program: Program, source: str, width: int, lanes: int, columns: int) -> Function:
    rows = {**program.rows({source: width, COLUMNS: columns}), source: 0, "": width, COLUMNS: 2 * width + 1}
    content = "repeated", program.operations, program.outputs, width, lanes
    return built("kernel", content, lambda: kernel(program, rows, "double", lanes, calls=False))


@cache
def _rollout(lanes: int) -> Function:
    arguments = (*[c_void_p] * 6, *[c_int64] * 6, c_void_p, c_int64, c_void_p)
    return built("rollout", ("rollout", lanes), lambda: rollout(lanes), *arguments)
