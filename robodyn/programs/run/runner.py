"""A program ready to run on arrays, by the executor that suits the work.

The choice depends on the work alone, by the rates of a typical machine: not on the speed of this one, on its number of
cores, or on what has been compiled before. For results of the executors differ by rounding, and the same work must give
the same digits wherever and whenever it is done.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from functools import cache
from threading import Lock
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import InputError, RobodynWarning
from robodyn.programs.program import Program
from robodyn.programs.run.llvm.machine import compiler_problem, one_line
from robodyn.programs.run.numpy_blocks import LARGEST, NumpyBlocks
from robodyn.support.threads import cores
from robodyn.support.wording import alternatives

if TYPE_CHECKING:
    from robodyn.programs.run.compiled_blocks import CompiledBlocks

EXECUTORS = ("auto", "numpy", "compiled")
NUMPY = 6e-10
"""Seconds of NumPy per operation and sample, on a server processor of 2023 with AVX-512."""
CALL = 4e-7
"""Seconds of NumPy per operation of a block, however few its samples."""
COMPILED = 4e-11
"""Seconds of machine code per operation and sample, by one thread."""
RUN = 2e-5
"""Seconds per run of machine code, however few its samples."""
BUILD = 6e-5
"""Seconds to compile an operation."""
START = 0.06
"""Seconds to import the compiler."""
LITTLE = 0.02
"""Seconds of NumPy that are not worth a word."""


class Choice(NamedTuple):
    """An executor and the reason for it, in words."""

    executor: str
    reason: str


class Work(NamedTuple):
    """Operations per sample, samples expected, calls in which they come, blocks in which NumPy would take them."""

    operations: int
    samples: int
    runs: int
    blocks: int


def times(work: Work) -> tuple[float, float]:
    """Return the seconds that NumPy and machine code take on a typical machine where nothing is compiled yet."""
    each = work.operations * work.samples
    by_numpy = work.operations * work.blocks * CALL + each * NUMPY
    return by_numpy, START + work.operations * BUILD + work.runs * RUN + each * COMPILED


def choice(work: Work) -> Choice:
    """Return the quicker executor; more samples in as many runs never turn machine code into NumPy."""
    by_numpy, by_code = times(work)
    if by_numpy < min(LITTLE, by_code):
        return Choice("numpy", "little work, and it starts at once")
    amount = f"{work.samples} samples of {work.operations} operations"
    if by_numpy <= by_code:
        return Choice("numpy", f"{amount} are done before machine code could be ready")
    return Choice("compiled", f"{amount} are worth machine code")


PAIRS = "double-double"
"""The name of an executor that is never chosen by itself."""
AS_ASKED = {executor: Choice(executor, "as asked") for executor in (*EXECUTORS, PAIRS)}
READY = Choice("compiled", "its machine code is ready")


class Run(NamedTuple):
    """What a call of a runner yields: values (samples, outputs), the executor that computed them, and why it."""

    values: NDArray[Any]
    choice: Choice


class Runner:
    """Runs a program on arrays of samples, for any number of threads at a time.

    Results of the executors differ by rounding. `auto` takes the one that suits the samples that are `expected`, which
    is always the same one for the same work. Where none are, it begins with NumPy and turns to machine code as soon as
    that would have been quicker for all samples so far: name an executor where such runs must agree to the bit.
    """

    def __init__(self, program: Program, widths: Mapping[str, int]) -> None:
        """Args: widths: how many columns the array of each source will have."""
        self.program, self.widths = program, dict(widths)
        self._numpy: dict[type, NumpyBlocks] = {}
        self._compiled: dict[type, CompiledBlocks] = {}
        self._problem: str | None = None
        self._samples = self._runs = self._blocks = 0
        self._counting, self._making = Lock(), Lock()

    def __call__(self, sources: Mapping[str, NDArray[Any]], samples: int, *given: Any, **options: Any) -> NDArray[Any]:
        return self.run(sources, samples, *given, **options).values

    def run(
        self,
        sources: Mapping[str, NDArray[Any]],
        samples: int,
        out: NDArray[Any] | None = None,
        *,
        executor: str = "auto",
        threads: int | None = None,
        expected: int = 0,
        dtype: Any = np.float64,
    ) -> Run:
        """Return the outputs of the program for every sample, and what computed them.

        Args:
            sources: for each source an array (samples, columns), in any layout.
            out: (samples, outputs) of `dtype`, written to if given; else each column of the values is contiguous.
            executor: "auto", "numpy", "compiled", or "double-double" (1e-30, some 100 times slower than "numpy").
            threads: of the compiled executor; None is all cores.
            expected: samples of the whole work that this run is a part of; 0 if they are not known.
            dtype: float64 or float32: of inputs, results and all operations.

        Raises:
            InputError: no such executor, or the compiled one cannot run here.

        Accuracy: as `NumpyBlocks` and `CompiledBlocks`.
        """
        kind = np.dtype(dtype).type
        if threads is not None:
            cores(threads)  # refuses those that cannot work
        if executor == PAIRS:
            from robodyn.programs.run.double_double import double_double

            values: NDArray[Any] = double_double(self.program, sources, samples).high  # the results rounded once
            if out is not None:
                out[...] = values
            return Run(values if out is None else out, AS_ASKED[PAIRS])
        if executor not in EXECUTORS:
            remedy = alternatives(str(executor), EXECUTORS, "executors")
            raise InputError(f"there is no executor {executor!r}", remedy=remedy)
        chosen = self._choice(kind, samples, expected) if executor == "auto" else AS_ASKED[executor]
        if chosen.executor == "compiled" and kind not in self._compiled and (problem := self._made(kind)):
            if executor == "compiled":
                raise InputError(f"the compiled executor cannot run: {problem}", remedy="choose auto or numpy")
            self._problem = problem
            _say(f"large work goes without machine code, tens of times slower: {problem}")
            chosen = Choice("numpy", problem)
        if chosen.executor == "compiled":
            return Run(self._compiled[kind](sources, samples, out, threads), chosen)
        by_numpy = self._by_numpy(kind)
        with self._counting:
            self._samples += samples
            self._runs += 1
            self._blocks += -(-samples // by_numpy.block)
        return Run(by_numpy(sources, samples, out), chosen)

    def _by_numpy(self, kind: type) -> NumpyBlocks:
        if kind not in self._numpy:
            self._numpy[kind] = NumpyBlocks(self.program, self.widths, kind)
        return self._numpy[kind]

    def _choice(self, kind: type, samples: int, expected: int) -> Choice:
        """Return the executor that suits the work: all that is expected, or all so far."""
        if self._problem:
            return Choice("numpy", self._problem)
        if kind in self._compiled and not expected:
            return READY
        with self._counting:
            done = (0, 0, 0) if expected else (self._samples, self._runs, self._blocks)

        def chosen(block: int) -> Choice:
            now = expected or samples
            return choice(Work(self.program.size, done[0] + now, done[1] + 1, done[2] - (-now // block)))

        at_best = chosen(LARGEST)  # NumPy has its steps laid out, which takes a while, only where it may be chosen
        return at_best if at_best.executor == "compiled" else chosen(self._by_numpy(kind).block)

    def _made(self, kind: type) -> str | None:
        if problem := compiler_problem():
            return problem
        from robodyn.programs.run.compiled_blocks import CompiledBlocks

        with self._making:
            if kind not in self._compiled:
                try:
                    self._compiled[kind] = CompiledBlocks(self.program, self.widths, kind)
                except (OSError, RuntimeError) as error:
                    return f"LLVM fails on this program ({one_line(error)})"
        return None


@cache
def _say(what: str) -> None:
    warnings.warn(what, RobodynWarning, stacklevel=2)
