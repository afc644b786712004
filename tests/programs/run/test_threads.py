"""One runner for many threads: every call gets its own results, and is told the executor that made them."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier, Thread

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.compiled_programs import needs_compiler, program_of

import robodyn
from robodyn.dynamics.plan import plan
from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.run.runner import Runner

PROGRAM = program_of(lambda x, y: [(x * y + x).sin() * y + x * x, x / (y * y + 1.0)], 2)
WIDTHS = {"x": 2}
THREADS = 8


@pytest.fixture(autouse=True)
def _fresh(monkeypatch, tmp_path):
    monkeypatch.setenv("ROBODYN_CACHE", str(tmp_path))


def _elsewhere(job):
    """Runs a job in another thread, and waits for its end."""
    thread = Thread(target=job)
    thread.start()
    thread.join()


@needs_compiler
def test_a_call_is_told_its_own_executor_whatever_others_ask_meanwhile(monkeypatch):
    """Another thread has its way while machine code is made, and after the choice, before the run."""
    x = np.random.default_rng(1).normal(size=(100, 2))
    a_runner = Runner(PROGRAM, WIDTHS)
    meanwhile = []

    def by_numpy():
        meanwhile.append(a_runner.run({"x": x}, len(x), executor="numpy").choice)

    class Interrupted(CompiledBlocks):
        def __init__(self, *given):
            super().__init__(*given)
            _elsewhere(by_numpy)

        def __call__(self, *given):
            _elsewhere(by_numpy)
            return super().__call__(*given)

    monkeypatch.setattr("robodyn.programs.run.compiled_blocks.CompiledBlocks", Interrupted)
    found = a_runner.run({"x": x}, len(x), executor="compiled")
    assert found.choice == ("compiled", "as asked")
    assert meanwhile == [("numpy", "as asked")] * 2
    np.testing.assert_array_equal(found.values, CompiledBlocks(PROGRAM, WIDTHS)({"x": x}, len(x)))


def _at_once(jobs):
    """What the jobs return, all begun at the same moment, each in a thread of its own."""
    barrier = Barrier(len(jobs))

    def begun(job):
        barrier.wait()
        return job()

    with ThreadPoolExecutor(len(jobs)) as pool:
        return list(pool.map(begun, jobs))


@needs_compiler
def test_machine_code_is_made_once_by_many_threads(monkeypatch):
    made = []

    class Counted(CompiledBlocks):
        def __init__(self, *given):
            made.append(given)
            super().__init__(*given)

    monkeypatch.setattr("robodyn.programs.run.compiled_blocks.CompiledBlocks", Counted)
    a_runner, x = Runner(PROGRAM, WIDTHS), np.ones((5, 2))
    _at_once([lambda: a_runner({"x": x}, 5, executor="compiled")] * THREADS)
    assert len(made) == 1


def test_torques_of_many_threads_on_one_robot():
    """From the first call on: no program is there yet."""
    model = busy_robot.__wrapped__()
    rng = np.random.default_rng(3)
    inputs = [rng.normal(size=(3, 200 + 50 * k, model.n)) for k in range(THREADS)]
    columns = [{name: rng.normal(size=len(states[0])) for name in BUSY_SCENE.columns} for states in inputs]

    def torques(k):
        return robodyn.inverse_dynamics(model, *inputs[k], scene=BUSY_SCENE, columns=columns[k], executor="numpy")

    plan.cache_clear()
    found = _at_once([lambda k=k: torques(k) for k in range(THREADS)])
    for k in range(THREADS):
        np.testing.assert_array_equal(found[k], torques(k))
