"""Every executor against the exact values of random programs and of robots, within the bound of rounding."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import cache, lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.oracles import golden_model, random_state, robot
from helpers.random_programs import OPERATIONS, programs, random_inputs, seeded
from helpers.rounding_bounds import bounds, exactly
from helpers.sampled import sampled
from hypothesis import given
from hypothesis import strategies as st
from mpmath import isnan

from robodyn.dynamics.plan import Plan
from robodyn.programs.run import numpy_blocks
from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.programs.scalar import CONSTANT, INPUT
from robodyn.scene.scene import Scene


class Executor(NamedTuple):
    """What makes a program ready to run: (program, widths) -> (sources, samples) -> outputs, all in one format.

    Its sines, cosines and exponentials are right to so many units in the last place.
    """

    ready: Callable[..., Any]
    dtype: Any = np.float64
    ulps: int = 1


EXECUTORS = {
    "numpy": Executor(NumpyBlocks),
    "numpy float32": Executor(partial(NumpyBlocks, dtype=np.float32), np.float32, ulps=3),
    "compiled": Executor(CompiledBlocks),
    "compiled float32": Executor(partial(CompiledBlocks, dtype=np.float32), np.float32),
}


SEEDS = 15
ROWS = 4
"""Samples with exact values; executors run on many copies of them, so that every lane of a block is looked at."""

each_executor = pytest.mark.parametrize("executor", EXECUTORS.values(), ids=EXECUTORS)
each_kind = pytest.mark.parametrize("tame", [True, False], ids=["tame", "wild"])


def outside(executor, program, widths, sources, limits, samples=ROWS):
    """What the executor gets wrong on that many samples, the given ones again and again."""
    with np.errstate(all="ignore"):
        repeated = {name: np.resize(x, (samples, x.shape[1])).astype(executor.dtype) for name, x in sources.items()}
    return limits.broken(executor.ready(program, widths)(repeated, samples))


@lru_cache(maxsize=1000)
def exact(seed, operations, tame):
    """The program of a seed, its sources with their widths, and the exact values of its operations."""
    program, widths = seeded(seed, operations, tame)
    sources = random_inputs(seed, widths, ROWS, tame)
    return program, widths, sources, exactly(program, sources, ROWS)


@lru_cache(maxsize=1000)
def drawn(seed, operations, tame, dtype=np.float64, ulps=1):
    """The program of a seed, its sources with their widths, and the bounds of its outputs."""
    program, widths, sources, values = exact(seed, operations, tame)
    return program, widths, sources, bounds(program, sources, ROWS, dtype, ulps, values)


MANY = pytest.param(range(SEEDS, 60), marks=pytest.mark.slow)


@each_executor
@each_kind
@pytest.mark.parametrize("operations", sampled([50, 4, 15, 1], 2))
@pytest.mark.parametrize("seeds", [range(SEEDS), MANY], ids=["some", "many"])
def test_programs_of_seeds(executor, operations, tame, seeds):
    for seed in seeds:
        case = drawn(seed, operations, tame, *executor[1:])
        assert not outside(executor, *case, samples=1 + 13 * seed % 700)


@each_executor
@each_kind
@given(data=st.data())
def test_programs_that_shrink(executor, tame, data):
    program, widths = data.draw(programs(tame))
    sources = random_inputs(data.draw(st.integers(0, 1000)), widths, ROWS, tame)
    assert not outside(executor, program, widths, sources, bounds(program, sources, ROWS, *executor[1:]))


@pytest.mark.slow
@each_executor
def test_a_program_of_thousands_of_operations(executor):
    program, *rest = drawn(0, 2500, True, *executor[1:])
    assert program.size > 1500
    assert not outside(executor, program, *rest)


ROBOTS = {
    "scara": lambda: (robot("scara"), Scene()),
    "puma560": lambda: (robot("puma560"), Scene()),
    "gripper": lambda: (robot("gripper"), Scene()),
    "free satellite": lambda: (robot("satellite", moving_base=True), Scene()),
    "tree": lambda: (golden_model("tree15_bf2_skew0.3"), Scene()),
    "every effect": lambda: (busy_robot(), BUSY_SCENE),
}


@cache
def wrenches(name, dtype, ulps):
    """Torques, base wrench and joint wrenches of a robot in random states, and their bounds."""
    model, scene = ROBOTS[name]()
    rng = np.random.default_rng(12)
    sources = dict(zip(("q", "qd", "qdd"), random_state(model, rng, ROWS), strict=True))
    sources["columns"] = rng.uniform(-2.0, 2.0, (ROWS, len(scene.columns)))
    program = Plan(model, scene).wrenches(joints=True)
    widths = {source: values.shape[1] for source, values in sources.items()}
    return program, widths, sources, bounds(program, sources, ROWS, dtype, ulps)


@each_executor
@pytest.mark.parametrize("name", sampled(ROBOTS, 3))
def test_robots(executor, name):
    *run, limits = wrenches(name, *executor[1:])
    assert limits.error.max() <= 200 * float(np.finfo(executor.dtype).eps) * abs(limits.exact).max()
    assert not outside(executor, *run, limits, samples=1000)


@each_kind
def test_programs_of_every_kind_are_drawn(tame):
    kinds, uses, depths, repeated, unread = set(), 0, 0, False, False
    for program, widths, *_ in (drawn(seed, 60, tame) for seed in range(SEEDS)):
        operands, depth = Counter(), []
        for op, a, b in program.operations:
            below = () if op in (INPUT, CONSTANT) else [k for k in (a, b) if k is not None]
            operands.update(below)
            depth.append(1 + max((depth[k] for k in below), default=0))
        kinds |= {program.operations[k][0] for k in program.outputs} | set(program.counts)
        uses, depths = max([uses, *operands.values()]), max([depths, *depth])
        repeated |= len(set(program.outputs)) < len(program.outputs)
        unread |= len(program.inputs) < sum(widths.values())
    assert kinds == {*OPERATIONS, INPUT, CONSTANT}
    assert uses >= 5
    assert depths >= 25
    assert repeated
    assert unread


def test_no_program_is_beyond_judgement():
    """Well-conditioned programs leave errors of a few roundings; of the others most outputs can be told."""
    tame, wild = ([drawn(seed, 60, kind)[-1] for seed in range(SEEDS)] for kind in (True, False))
    off = np.concatenate([(x.error / (1 + abs(x.exact))).ravel() for x in tame])
    assert np.mean(off <= 1e-14) > 0.95
    assert off.max() <= 1e-12
    assert np.mean(np.concatenate([x.known.ravel() for x in wild])) > 0.6
    assert np.mean(np.concatenate([np.frompyfunc(isnan, 1, 1)(x.exact).ravel() for x in wild])) > 0.05


@each_kind
@pytest.mark.parametrize("op", sorted(set(OPERATIONS)))
def test_an_operation_that_is_slightly_wrong_is_found(monkeypatch, op, tame):
    right = numpy_blocks.UFUNCS[op]
    monkeypatch.setitem(numpy_blocks.UFUNCS, op, lambda *args: np.multiply(right(*args), 1.0 + 1e-13, out=args[-1]))
    slightly_wrong = Executor(NumpyBlocks)
    assert any(outside(slightly_wrong, *drawn(seed, 15, tame)) for seed in range(SEEDS))
