"""Which executor suits a piece of work, and why."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import NamedTuple

EXECUTORS = ("auto", "numpy", "compiled")


class Choice(NamedTuple):
    """An executor and the reason for it, in words."""

    executor: str
    reason: str


@dataclass(frozen=True)
class Rates:
    """Seconds.

    Attributes:
        call: per operation of a block by NumPy, however few its samples.
        numpy: per operation and sample by NumPy.
        run: per run of machine code, however few its samples.
        compiled: per operation and sample by machine code, one thread.
        build: per operation compiled.
        load: to bring machine code to memory from the cache.
        start: to import the compiler.
    """

    call: float
    numpy: float
    run: float
    compiled: float
    build: float
    load: float
    start: float

    @property
    def sane(self) -> bool:
        """Whether a machine may have these rates, and machine code is faster per sample."""
        near = (1e-3 < rate / usual < 1e3 for rate, usual in zip(astuple(self), astuple(TYPICAL), strict=True))
        return all(near) and self.compiled < self.numpy


TYPICAL = Rates(call=4e-7, numpy=6e-10, run=2e-5, compiled=4e-11, build=6e-5, load=2e-3, start=0.06)
"""A server processor of 2023 with AVX-512."""


class Work(NamedTuple):
    """What is to be computed.

    Attributes:
        operations: per sample.
        samples: all that are expected.
        runs: calls in which they come.
        blocks: how many times NumPy would go through the operations.
        threads: that may work at a time.
    """

    operations: int
    samples: int
    runs: int
    blocks: int
    threads: int


class Readiness(NamedTuple):
    """How much of the compiled executor is there already.

    Attributes:
        kept: the machine code lies in the cache.
        started: the compiler has been imported.
    """

    kept: bool
    started: bool


def times(work: Work, ready: Readiness, rates: Rates) -> tuple[float, float]:
    """Seconds that NumPy and machine code would take, with what is left to do before machine code runs."""
    each = work.operations * work.samples
    by_numpy = work.operations * work.blocks * rates.call + each * rates.numpy
    start = (0.0 if ready.started else rates.start) + (rates.load if ready.kept else work.operations * rates.build)
    return by_numpy, start + work.runs * rates.run + each * rates.compiled / work.threads


def choice(work: Work, ready: Readiness, rates: Rates) -> Choice:
    """The quicker executor by these rates.

    For rates that are `sane`, more samples in as many runs never turn machine code into NumPy.
    """
    by_numpy, by_code = times(work, ready, rates)
    amount = f"{work.samples} samples of {work.operations} operations"
    if by_numpy <= by_code:
        return Choice("numpy", f"{amount} are done before machine code could be ready")
    return Choice("compiled", f"{amount} are worth machine code")
