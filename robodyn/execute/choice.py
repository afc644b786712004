"""Which executor suits a piece of work, and why."""

from __future__ import annotations

from typing import NamedTuple

from robodyn.execute.rates import Rates

EXECUTORS = ("auto", "numpy", "compiled")


class Choice(NamedTuple):
    """An executor and the reason for it, in words."""

    executor: str
    reason: str


class Work(NamedTuple):
    """What is to be computed.

    Attributes:
        operations: per sample.
        samples: all that are expected.
        blocks: how many times NumPy would go through the operations.
        threads: that may work at a time.
    """

    operations: int
    samples: int
    blocks: int
    threads: int


class Readiness(NamedTuple):
    """How much of the compiled executor is there already."""

    built: bool = False
    kept: bool = False
    started: bool = False


def times(work: Work, ready: Readiness, rates: Rates) -> tuple[float, float]:
    """Seconds that NumPy and machine code would take, with what is left to do before machine code runs."""
    each = work.operations * work.samples
    by_numpy = work.operations * work.blocks * rates.call + each * rates.numpy
    start = 0.0 if ready.started or ready.built else rates.start
    if not ready.built:
        start += rates.load if ready.kept else work.operations * rates.build
    return by_numpy, start + each * rates.compiled / work.threads


def choice(work: Work, ready: Readiness, rates: Rates) -> Choice:
    """The quicker executor by these rates."""
    by_numpy, by_code = times(work, ready, rates)
    figures = f"about {_seconds(by_numpy)} by numpy, {_seconds(by_code)} compiled"
    return Choice("numpy" if by_numpy <= by_code else "compiled", f"{figures}, for {work.samples} samples")


def _seconds(value: float) -> str:
    return f"{value:.2g} s" if value >= 0.1 else f"{1e3 * value:.2g} ms"
