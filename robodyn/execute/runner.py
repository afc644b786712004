"""A program ready to run on arrays, by the executor that suits the work."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Mapping
from functools import cache
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import InputError
from robodyn.execute.choice import EXECUTORS, Choice, Readiness, Work, choice, times
from robodyn.execute.numpy_blocks import NumpyBlocks
from robodyn.execute.rates import TYPICAL, Rates, measured_rates, stored_rates
from robodyn.trace.program import Program

if TYPE_CHECKING:
    from robodyn.execute.compiled_blocks import CompiledBlocks

WORTH_MEASURING = 0.5
"""Seconds of work by NumPy from which the rates of this machine are measured, if they are not known."""


class Runner:
    """Runs a program on arrays of samples.

    `auto` begins with NumPy and turns to machine code as soon as that would have been quicker for the samples seen so
    far and those announced; results of the two differ by rounding. Name an executor where runs must agree to the bit.

    Attributes:
        choice: the executor of the last run, and why.
    """

    def __init__(self, program: Program, widths: Mapping[str, int]) -> None:
        """Args: widths: how many columns the array of each source will have."""
        self.program, self.widths = program, dict(widths)
        self.choice = Choice("numpy", "nothing has run yet")
        self._numpy: dict[str, NumpyBlocks] = {}
        self._compiled: dict[str, CompiledBlocks] = {}
        self._samples = self._blocks = 0

    def __call__(
        self,
        sources: Mapping[str, NDArray[Any]],
        samples: int,
        out: NDArray[Any] | None = None,
        *,
        executor: str = "auto",
        threads: int | None = None,
        expected: int = 0,
        dtype: Any = np.float64,
    ) -> NDArray[Any]:
        """The outputs of the program for every sample.

        Args:
            sources: for each source an array (samples, columns), in any layout.
            samples: how many.
            out: (samples, outputs) of `dtype`, written to if given.
            executor: "auto", "numpy" or "compiled".
            threads: of the compiled executor; None is all cores.
            expected: samples of all runs that will follow, with this one.
            dtype: float64 or float32: of inputs, results and all operations.

        Returns:
            (samples, outputs); where `out` is not given each column is contiguous.

        Raises:
            InputError: no such executor, or the compiled one cannot run here.

        Accuracy: as `NumpyBlocks` and `CompiledBlocks`.
        """
        kind = np.dtype(dtype).name
        workers = _threads(threads)
        if self._chosen(executor, kind, samples, max(expected, samples), workers) == "compiled":
            return self._by_code(kind)(sources, samples, out, workers)
        run = self._by_numpy(kind)
        self._samples += samples
        self._blocks += -(-samples // run.block)
        return run(sources, samples, out)

    def _chosen(self, executor: str, kind: str, samples: int, expected: int, threads: int) -> str:
        if executor == "auto":
            if kind not in self._compiled:
                self.choice = self._choice(kind, self._samples + expected, threads)
        elif executor == "compiled":
            if problem := unavailable():
                raise InputError(f"the compiled executor cannot run: {problem}", remedy="choose auto or numpy")
            self.choice = Choice(executor, "as asked")
        elif executor == "numpy":
            self.choice = Choice(executor, "as asked")
        else:
            raise InputError(f"there is no executor {executor!r}", remedy=f"choose {', '.join(EXECUTORS)}")
        return self.choice.executor

    def _choice(self, kind: str, samples: int, threads: int) -> Choice:
        """The quicker executor, finding out no more than the work is worth."""
        blocks = self._blocks + -(-samples // self._by_numpy(kind).block)
        work = Work(self.program.size, samples, blocks, threads)
        rates = stored_rates() or TYPICAL
        hoped = choice(work, Readiness(kept=True, started="llvmlite.binding" in sys.modules), rates)
        if hoped.executor == "numpy":
            return hoped
        if problem := unavailable():
            _say(f"large work goes without machine code, tens of times slower: {problem}")
            return Choice("numpy", problem)
        if times(work, Readiness(), rates)[0] > WORTH_MEASURING and stored_rates() is None:
            rates = _measured()
        return choice(work, Readiness(kept=self._is_kept(kind), started=True), rates)

    def _is_kept(self, kind: str) -> bool:
        from robodyn.execute.compiled_blocks import content_of
        from robodyn.execute.llvm.build import is_kept

        return is_kept(content_of(self.program, self.widths, kind))

    def _by_numpy(self, kind: str) -> NumpyBlocks:
        if kind not in self._numpy:
            self._numpy[kind] = NumpyBlocks(self.program, self.widths, kind)
        return self._numpy[kind]

    def _by_code(self, kind: str) -> CompiledBlocks:
        if kind not in self._compiled:
            from robodyn.execute.compiled_blocks import CompiledBlocks

            self._compiled[kind] = CompiledBlocks(self.program, self.widths, kind)
        return self._compiled[kind]


@cache
def unavailable() -> str | None:
    """Why there is no compiled executor here; None if there is."""
    try:
        from robodyn.execute.llvm.machine import host

        here = host()
    except (ImportError, OSError, RuntimeError) as error:
        reason = "llvmlite is not installed" if find_spec("llvmlite") is None else f"llvmlite does not load ({error})"
        return f"{reason}; pip install llvmlite"
    return None if here.fused else f"the processor ({here.cpu}) has no fused multiply-add"


@cache
def _measured() -> Rates:
    from robodyn.execute.compiled_blocks import CompiledBlocks

    return measured_rates(CompiledBlocks)


@cache
def _say(what: str) -> None:
    """A warning, once."""
    warnings.warn(what, RuntimeWarning, stacklevel=2)


def _threads(asked: int | None) -> int:
    if asked is not None:
        if asked < 1:
            raise InputError(f"{asked} threads cannot work", remedy="1 or more")
        return asked
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1
