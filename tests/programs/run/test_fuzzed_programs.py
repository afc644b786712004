"""Every executor against the exact values of random programs: errors of a few roundings."""

from __future__ import annotations

from functools import lru_cache, partial

import numpy as np
import pytest
from helpers.random_programs import OPERATIONS, random_inputs, seeded

from robodyn.programs.run import numpy_blocks
from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.run.multiprecision import Multiprecision
from robodyn.programs.run.numpy_blocks import NumpyBlocks

SINGLE = {"numpy float32": NumpyBlocks, "compiled float32": CompiledBlocks}
EXECUTORS = {"numpy": NumpyBlocks, "compiled": CompiledBlocks}
EXECUTORS |= {name: partial(each, dtype=np.float32) for name, each in SINGLE.items()}
SEEDS = 8
ROWS = 4
"""Samples with exact values; executors run on many copies of them, so that every lane of a block is looked at."""

each_executor = pytest.mark.parametrize("executor", EXECUTORS)


def format_of(executor):
    return np.float32 if executor in SINGLE else np.float64


def off(executor, program, widths, sources, exact, samples=ROWS):
    """Errors in roundings of 1 + |exact value|, on that many samples, the given ones again and again."""
    dtype = format_of(executor)
    repeated = {name: np.resize(x, (samples, x.shape[1])).astype(dtype) for name, x in sources.items()}
    found = EXECUTORS[executor](program, widths)(repeated, samples)
    again = exact[np.arange(samples) % ROWS].astype(float)
    return np.abs(found - again) / (1.0 + np.abs(again)) / np.finfo(dtype).eps


def values(program, sources, dtype):
    """Exact ones, of inputs in this format."""
    return Multiprecision(program, digits=50)({name: x.astype(dtype) for name, x in sources.items()}, ROWS)


@lru_cache(maxsize=1000)
def drawn(seed, operations, dtype=np.float64):
    """The program of a seed, its sources with their widths, and exact values."""
    program, widths = seeded(seed, operations)
    sources = random_inputs(seed, widths, ROWS)
    return program, widths, sources, values(program, sources, dtype)


@each_executor
@pytest.mark.parametrize("operations", [50, *(pytest.param(x, marks=pytest.mark.slow) for x in (15, 1000))])
def test_programs_of_seeds(executor, operations):
    cases = [drawn(seed, operations, format_of(executor)) for seed in range(1 if operations > 50 else SEEDS)]
    errors = [off(executor, *case, samples=1 + 67 * k).ravel() for k, case in enumerate(cases)]
    assert np.mean(np.concatenate(errors) <= 50) > 0.95
    assert np.max(np.concatenate(errors)) <= 5000


@pytest.mark.parametrize("op", sorted(set(OPERATIONS)))
def test_an_operation_that_is_slightly_wrong_is_found(monkeypatch, op):
    right = numpy_blocks.UFUNCS[op]
    monkeypatch.setitem(numpy_blocks.UFUNCS, op, lambda *args: np.multiply(right(*args), 1.0 + 1e-11, out=args[-1]))
    assert max(off("numpy", *drawn(seed, 50)).max() for seed in range(SEEDS)) > 5000
