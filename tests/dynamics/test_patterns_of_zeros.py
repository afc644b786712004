"""Columns of zeros in ever new places: how many programs are traced and compiled for them."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from helpers.compiled_programs import needs_compiler
from helpers.motions import Pieces
from helpers.oracles import ROBOTS

import robodyn
from robodyn.dynamics import forward, inverse, plan
from robodyn.dynamics import momenta as momentum
from robodyn.loads import accumulate
from robodyn.programs import program
from robodyn.programs.run.compiled_blocks import CompiledBlocks

PATTERNS = list(product((0.0, 1.0), repeat=3))[1:]
"""Which of three joints move: in how many ways not all are still."""
ROWS = 20


@pytest.fixture
def model():
    """One of its own, whose programs nobody else has traced."""
    return robodyn.load(ROBOTS / "puma.urdf")


@pytest.fixture
def traced(monkeypatch):
    made, trace = [], program.trace

    def counted(*given):
        made.append(given)
        return trace(*given)

    for module in (program, plan, inverse, forward, momentum, robodyn.dynamics.forward):
        if hasattr(module, "trace"):
            monkeypatch.setattr(module, "trace", counted)
    return made


def _state(moves):
    rng = np.random.default_rng(7)
    return rng.normal(size=(3, ROWS, 3)) * np.array([[[1.0] * 3], [moves], [moves]])


CALLS = {
    "inverse dynamics": robodyn.inverse_dynamics,
    "forward dynamics": robodyn.forward_dynamics,
    "bias forces": lambda model, q, qd, _, **how: robodyn.bias_forces(model, q, qd, **how),
    "momenta": lambda model, q, qd, _, **how: robodyn.momenta(model, q, qd, **how),
}


@pytest.mark.parametrize(
    ("name", "executor"),
    [*((name, "numpy") for name in CALLS), pytest.param("inverse dynamics", "compiled", marks=needs_compiler)],
)
def test_patterns_share_a_program(name, executor, model, traced, monkeypatch, tmp_path):
    """Robots at rest have programs of their own: without speeds, accelerations or torques."""
    monkeypatch.setenv("ROBODYN_CACHE", str(tmp_path))
    built = []
    name_of = "robodyn.programs.run.compiled_blocks.CompiledBlocks"
    monkeypatch.setattr(name_of, lambda *given: (built.append(given), CompiledBlocks(*given))[1])
    for moves in PATTERNS:
        CALLS[name](model, *_state(moves), executor=executor)
    assert len(traced) == 1
    assert len(built) == (executor == "compiled")
    for zeros in product((0.0, 1.0), repeat=3):
        CALLS[name](model, *(_state(PATTERNS[3]) * np.reshape(zeros, (3, 1, 1))), executor=executor)
    assert len(traced) <= 8
    assert len(built) <= 8


def test_a_trajectory_has_one_program_of_its_own():
    """That of its loads, from which what stands still is left out; the checks are the same for all."""
    model = robodyn.load(ROBOTS / "puma.urdf")
    caches = accumulate._loads, accumulate._check_runners, inverse.torque_runner, momentum.momentum_runner
    before = [cache.cache_info().misses for cache in caches]
    results = [
        robodyn.torques(
            model, robodyn.motion(model, np.arange(ROWS) / 100, *_state(moves)), sizing=True, momentum=momentum.View()
        )
        for moves in PATTERNS
    ]
    made = [cache.cache_info().misses - count for cache, count in zip(caches, before, strict=True)]
    assert made == [len(PATTERNS), 1, 1, 1]
    assert len({result.operations for result in results}) > 3
    assert results[0].effects[2].verdict.reason == "1 of 3 velocities are not zero"


def test_blocks_of_a_trajectory_share_what_all_so_far_have_in_common(model):
    """However the joints take turns, there are no more programs than joints that have begun to move."""
    rng = np.random.default_rng(3)
    moves = np.ones((40, 1, 3)) * [1.0, 0.0, 0.0]
    moves[5:, :, 1:3] = rng.integers(0, 2, (35, 1, 2))
    q, qd, qdd = rng.normal(size=(3, 400, 3)) * np.repeat(moves, 10, axis=0).reshape(400, 3)
    trajectory = robodyn.motion(model, np.arange(400) / 100, q, qd, qdd)
    before = accumulate._loads.cache_info().misses
    result = robodyn.torques(model, Pieces(trajectory, [10] * 40))
    assert accumulate._loads.cache_info().misses - before <= 3
    assert result.operations == robodyn.torques(model, trajectory).operations


@pytest.mark.parametrize("executor", ["numpy", pytest.param("compiled", marks=needs_compiler)])
def test_results_do_not_depend_on_patterns_seen_before(executor, model):
    """Nor on whether columns of zeros stand alone or among others."""
    fresh = robodyn.load(ROBOTS / "puma.urdf")
    states = [_state(moves) for moves in PATTERNS]
    warm = [robodyn.inverse_dynamics(model, *state, executor=executor) for state in states]
    for state, found in list(zip(states, warm, strict=True))[::-3]:
        np.testing.assert_array_equal(robodyn.inverse_dynamics(fresh, *state, executor=executor), found)
    together = robodyn.inverse_dynamics(model, *np.concatenate(states, axis=1), executor=executor)
    np.testing.assert_array_equal(together, np.concatenate(warm))
