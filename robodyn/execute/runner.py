"""A program ready to run on arrays, by the executor that suits the work."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import InputError
from robodyn.execute.choice import EXECUTORS, Choice, Work, choice
from robodyn.execute.llvm.machine import compiler, one_line
from robodyn.execute.numpy_blocks import NumpyBlocks
from robodyn.trace.program import Program
from robodyn.wording import alternatives

if TYPE_CHECKING:
    from robodyn.execute.compiled_blocks import CompiledBlocks

PAIRS = "double-double"
"""The name of an executor that is never chosen by itself."""


class Runner:
    """Runs a program on arrays of samples.

    Results of the executors differ by rounding. `auto` takes the one that suits the samples that are `expected`, which
    is always the same one for the same work. Where none are, it begins with NumPy and turns to machine code as soon as
    that would have been quicker for all samples so far: name an executor where such runs must agree to the bit.

    Attributes:
        choice: the executor of the last run, and why.
    """

    def __init__(self, program: Program, widths: Mapping[str, int]) -> None:
        """Args: widths: how many columns the array of each source will have."""
        self.program, self.widths = program, dict(widths)
        self.choice = Choice("numpy", "nothing has run yet")
        self._numpy: dict[type, NumpyBlocks] = {}
        self._compiled: dict[type, CompiledBlocks] = {}
        self._problem: str | None = None
        self._samples = self._runs = self._blocks = 0

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
            executor: "auto", "numpy", "compiled", or "double-double" (1e-30, some 100 times slower than "numpy").
            threads: of the compiled executor; None is all cores.
            expected: samples of the whole work that this run is a part of; 0 if they are not known.
            dtype: float64 or float32: of inputs, results and all operations.

        Returns:
            (samples, outputs); where `out` is not given each column is contiguous.

        Raises:
            InputError: no such executor, or the compiled one cannot run here.

        Accuracy: as `NumpyBlocks` and `CompiledBlocks`.
        """
        kind, workers = np.dtype(dtype).type, cores(threads)
        if executor == PAIRS:
            return self._in_pairs(sources, samples, out)
        if self._chosen(executor, kind, samples, expected) == "compiled":
            return self._compiled[kind](sources, samples, out, workers)
        run = self._by_numpy(kind)
        self._samples += samples
        self._runs += 1
        self._blocks += -(-samples // run.block)
        return run(sources, samples, out)

    def _in_pairs(self, sources: Mapping[str, NDArray[Any]], samples: int, out: NDArray[Any] | None) -> NDArray[Any]:
        """The high parts of the results, which are the results rounded once."""
        from robodyn.execute.double_double import DoubleDouble

        self.choice = Choice(PAIRS, "as asked")
        high: NDArray[Any] = DoubleDouble(self.program)(sources, samples).high
        if out is None:
            return high
        out[...] = high
        return out

    def _chosen(self, executor: str, kind: type, samples: int, expected: int) -> str:
        """The executor to use, which is ready."""
        if executor == "auto":
            self.choice = self._choice(kind, samples, expected)
        elif executor in EXECUTORS:
            self.choice = Choice(executor, "as asked")
        else:
            remedy = alternatives(str(executor), EXECUTORS, "executors")
            raise InputError(f"there is no executor {executor!r}", remedy=remedy)
        if self.choice.executor == "compiled" and (problem := self._made(kind)):
            if executor == "compiled":
                raise InputError(f"the compiled executor cannot run: {problem}", remedy="choose auto or numpy")
            self._problem, self.choice = problem, Choice("numpy", problem)
            _say(f"large work goes without machine code, tens of times slower: {problem}")
        return self.choice.executor

    def _choice(self, kind: type, samples: int, expected: int) -> Choice:
        """The executor that suits the work: all that is expected, or all so far."""
        if self._problem:
            return Choice("numpy", self._problem)
        size, block = self.program.size, self._by_numpy(kind).block
        if expected:
            return choice(Work(size, expected, 1, -(-expected // block)))
        if kind in self._compiled:
            ready = Choice("compiled", "its machine code is ready")
            return self.choice if self.choice.executor == "compiled" else ready
        return choice(Work(size, self._samples + samples, self._runs + 1, self._blocks + -(-samples // block)))

    def _by_numpy(self, kind: type) -> NumpyBlocks:
        if kind not in self._numpy:
            self._numpy[kind] = NumpyBlocks(self.program, self.widths, kind)
        return self._numpy[kind]

    def _made(self, kind: type) -> str | None:
        """Makes the compiled executor unless it is there already; what stands against it."""
        if kind in self._compiled:
            return None
        if problem := compiler().problem:
            return problem
        from robodyn.execute.compiled_blocks import CompiledBlocks

        try:
            self._compiled[kind] = CompiledBlocks(self.program, self.widths, kind)
        except (OSError, RuntimeError) as error:
            return f"LLVM fails on this program ({one_line(error)})"
        return None


@cache
def _say(what: str) -> None:
    """A warning, once."""
    warnings.warn(what, RuntimeWarning, stacklevel=2)


def cores(asked: int | None = None) -> int:
    """The number of threads asked for; None is as many as the process may use cores.

    Raises:
        InputError: less than 1.
    """
    if asked is not None:
        if asked < 1:
            raise InputError(f"{asked} threads cannot work", remedy="1 or more")
        return asked
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1
