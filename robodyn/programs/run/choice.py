"""Which executor suits a piece of work, and why.

The choice depends on the work alone, by the rates of a typical machine: not on the speed of this one, on its number of
cores, or on what has been compiled before. For results of the executors differ by rounding, and the same work must give
the same digits wherever and whenever it is done.
"""

from __future__ import annotations

from typing import NamedTuple

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
    """What is to be computed.

    Attributes:
        operations: per sample.
        samples: all that are expected.
        runs: calls in which they come.
        blocks: how many times NumPy would go through the operations.
    """

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
