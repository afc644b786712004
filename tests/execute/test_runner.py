"""The executor that a Runner takes, what it finds out before, and what it does where machine code fails."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from compiled_programs import needs_compiler, program_of

from robodyn.errors import InputError
from robodyn.execute import rates, runner
from robodyn.execute.choice import TYPICAL, Readiness, Work, choice
from robodyn.execute.compiled_blocks import CompiledBlocks
from robodyn.execute.llvm import machine
from robodyn.execute.numpy_blocks import NumpyBlocks
from robodyn.execute.runner import Runner


def _sums(x, y, turns):
    for _ in range(turns):
        x, y = x * y, x * 0.5 + y
    return [x.sin(), y]


PROGRAM = program_of(lambda x, y: _sums(x, y, 100), 2)
LONG = program_of(lambda x, y: _sums(x, y, 1000), 2)
X = np.random.default_rng(3).uniform(-2, 2, (50, 2))
HUGE = 10**9


@pytest.fixture(autouse=True)
def fresh(monkeypatch, tmp_path):
    """An empty cache, rates that are known, and nothing said or measured in this process."""
    monkeypatch.setenv("ROBODYN_CACHE", str(tmp_path))
    monkeypatch.setattr(rates, "stored_rates", lambda: replace(TYPICAL))
    for name in ("_say", "_measured"):
        monkeypatch.setattr(runner, name, cache(getattr(runner, name).__wrapped__))


def made(program=PROGRAM):
    return Runner(program, {"x": 2})


def run(a_runner, **options):
    return a_runner({"x": X.astype(options.get("dtype", np.float64))}, len(X), **options)


BY_NUMPY = NumpyBlocks(PROGRAM, {"x": 2})({"x": X}, len(X))


def test_little_work_is_done_by_numpy():
    a_runner = made()
    np.testing.assert_array_equal(run(a_runner), BY_NUMPY)
    assert a_runner.choice == ("numpy", "little work, and it starts at once")


@needs_compiler
def test_much_work_is_done_by_machine_code():
    a_runner = made()
    found = run(a_runner, expected=HUGE)
    np.testing.assert_array_equal(found, CompiledBlocks(PROGRAM, {"x": 2})({"x": X}, len(X)))
    assert a_runner.choice == ("compiled", "1000000000 samples of 301 operations are worth machine code")


@needs_compiler
def test_machine_code_is_used_once_it_is_there():
    a_runner = made()
    run(a_runner, executor="compiled")
    run(a_runner, executor="numpy")
    run(a_runner)
    assert a_runner.choice == ("compiled", "its machine code is ready")


@needs_compiler
def test_later_blocks_keep_the_reason_of_the_first():
    a_runner = made()
    run(a_runner, expected=HUGE)
    first = a_runner.choice
    run(a_runner)
    assert a_runner.choice == first


@needs_compiler
def test_explicit_executors_do_not_decide_for_the_others():
    a_runner = made()
    for executor, expected in (("compiled", "compiled"), ("numpy", "numpy"), ("auto", "compiled")):
        run(a_runner, executor=executor)
        assert a_runner.choice.executor == expected
    run(a_runner, dtype=np.float32)
    assert a_runner.choice.executor == "numpy", "there is no machine code for this format yet"
    run(a_runner)
    assert a_runner.choice.executor == "compiled"


def test_explicit_numpy_runs_any_amount():
    a_runner = made()
    np.testing.assert_array_equal(run(a_runner, executor="numpy", expected=HUGE), BY_NUMPY)
    assert a_runner.choice == ("numpy", "as asked")


@needs_compiler
def test_small_calls_turn_to_machine_code_once_it_would_have_paid(monkeypatch):
    """As `choice` has it for all samples so far."""
    machine.compiler()
    slow = replace(TYPICAL, call=1e-5, numpy=1e-8, run=1.5e-3, build=1e-4)
    monkeypatch.setattr(rates, "stored_rates", lambda: slow)
    monkeypatch.setattr(runner, "WORTH_ASKING", 0.0)
    ready = Readiness(kept=False, started=True)
    executors = [choice(Work(301, 50 * k, k, k, 1), ready, slow).executor for k in range(1, 30)]
    assert "numpy" in executors
    assert "compiled" in executors
    a_runner, found = made(), []
    for _ in executors:
        run(a_runner, threads=1)
        found.append(a_runner.choice.executor)
    assert found == executors


@needs_compiler
def test_machine_code_that_is_kept_is_used_sooner():
    machine.compiler()
    first, again = made(LONG), made(LONG)
    run(first, expected=2000)
    assert first.choice.executor == "numpy"
    CompiledBlocks(LONG, {"x": 2})
    run(again, expected=2000)
    assert again.choice.executor == "compiled"


def _counted(monkeypatch, module, name, answer=None):
    calls = []

    def call(*_):
        calls.append(name)
        return answer

    monkeypatch.setattr(module, name, call)
    return calls


@needs_compiler
def test_rates_are_measured_once_and_only_for_work_that_is_worth_it(monkeypatch):
    looked = _counted(monkeypatch, rates, "stored_rates")
    measured = _counted(monkeypatch, rates, "measured_rates", replace(TYPICAL))
    for _ in range(3):
        run(made())
    assert not looked, "little work looks at no file"
    for _ in range(3):
        run(made(LONG), expected=2000)
    assert looked
    assert not measured
    for _ in range(3):
        run(made(), expected=HUGE)
    assert len(measured) == 1


def test_known_rates_are_read_once_by_a_runner(monkeypatch):
    looked = _counted(monkeypatch, rates, "stored_rates", replace(TYPICAL, compiled=5e-10))
    monkeypatch.setattr(runner, "WORTH_ASKING", 0.0)
    a_runner = made()
    for _ in range(5):
        run(a_runner)
    assert len(looked) == 1


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("compield", "did you mean 'compiled'?"),
        ("gpu", "executors: 'auto', 'numpy', 'compiled'"),
        (7, "executors: "),
    ],
)
def test_executor_that_does_not_exist(name, remedy):
    with pytest.raises(InputError) as error:
        run(made(), executor=name)
    assert str(error.value).startswith(f"there is no executor {name!r} ({remedy}")


@pytest.mark.parametrize("executor", ["auto", "numpy", "compiled"])
@pytest.mark.parametrize("threads", [0, -1])
def test_threads_that_cannot_work(executor, threads):
    with pytest.raises(InputError, match=rf"{threads} threads cannot work \(1 or more\)"):
        run(made(), executor=executor, threads=threads)


@needs_compiler
@pytest.mark.parametrize("dtype", [">f8", "<f8", ">f4", "<f4"])
def test_order_of_bytes_makes_no_difference(dtype):
    expected = X.astype(dtype), np.dtype(dtype).newbyteorder("=")
    for executor in ("numpy", "compiled"):
        found = made()({"x": expected[0]}, len(X), executor=executor, dtype=dtype)
        native = made()({"x": expected[0].astype(expected[1])}, len(X), executor=executor, dtype=expected[1])
        np.testing.assert_array_equal(found, native)
