"""The executor that a Runner takes, what it finds out before, and what it does where machine code fails."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from helpers.compiled_programs import needs_compiler, program_of

from robodyn.errors import InputError
from robodyn.programs.run import runner
from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.programs.run.runner import Runner, Work, choice


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
    """An empty cache, and nothing said in this process."""
    monkeypatch.setenv("ROBODYN_CACHE", str(tmp_path))
    monkeypatch.setattr(runner, "_say", cache(runner._say.__wrapped__))


def made(program=PROGRAM):
    return Runner(program, {"x": 2})


def run(a_runner, **options):
    return a_runner.run({"x": X.astype(options.get("dtype", np.float64))}, len(X), **options)


BY_NUMPY = NumpyBlocks(PROGRAM, {"x": 2})({"x": X}, len(X))


def test_little_work_is_done_by_numpy():
    found = run(made())
    np.testing.assert_array_equal(found.values, BY_NUMPY)
    assert found.choice == ("numpy", "little work, and it starts at once")


@needs_compiler
def test_much_work_is_done_by_machine_code():
    found = run(made(), expected=HUGE)
    np.testing.assert_array_equal(found.values, CompiledBlocks(PROGRAM, {"x": 2})({"x": X}, len(X)))
    assert found.choice == ("compiled", "1000000000 samples of 301 operations are worth machine code")


@needs_compiler
def test_machine_code_is_used_once_it_is_there():
    a_runner = made()
    run(a_runner, executor="compiled")
    run(a_runner, executor="numpy")
    assert run(a_runner).choice == ("compiled", "its machine code is ready")


@needs_compiler
def test_later_blocks_keep_the_reason_of_the_first():
    a_runner = made()
    first = run(a_runner, expected=HUGE).choice
    assert run(a_runner, expected=HUGE).choice == first


@needs_compiler
def test_explicit_executors_do_not_decide_for_the_others():
    a_runner = made()
    for executor, expected in (("compiled", "compiled"), ("numpy", "numpy"), ("auto", "compiled")):
        assert run(a_runner, executor=executor).choice.executor == expected
    found = run(a_runner, dtype=np.float32)
    assert found.choice.executor == "numpy", "there is no machine code for this format yet"
    assert run(a_runner).choice.executor == "compiled"


def test_explicit_numpy_runs_any_amount():
    found = run(made(), executor="numpy", expected=HUGE)
    np.testing.assert_array_equal(found.values, BY_NUMPY)
    assert found.choice == ("numpy", "as asked")


@needs_compiler
def test_small_calls_turn_to_machine_code_once_it_would_have_paid():
    """As `choice` has it for all samples so far."""
    executors = [choice(Work(PROGRAM.size, 50 * k, k, k)).executor for k in range(1, 1000)]
    turn = executors.index("compiled")
    a_runner = made()
    assert [run(a_runner).choice.executor for _ in executors[: turn + 3]] == executors[: turn + 3]


@needs_compiler
@pytest.mark.parametrize("expected", [1000, HUGE])
def test_announced_work_is_done_the_same_way_whatever_came_before(expected):
    """In a cold process, with machine code at hand, and after much other work."""
    cold, warm = made(), made()
    first = run(cold, expected=expected)
    for _ in range(3):
        run(warm, executor="compiled")
        run(warm)
    found = run(warm, expected=expected)
    np.testing.assert_array_equal(found.values, first.values)
    assert found.choice == first.choice
    assert found.choice.executor == ("compiled" if expected == HUGE else "numpy")


def test_announced_work_is_done_the_same_way_in_every_block():
    """The last block may be of one sample, which as the size of all blocks would be worth machine code."""
    a_runner = made()
    choices = [a_runner.run({"x": X[:rows]}, rows, expected=20_000).choice for rows in (50, 50, 1)]
    assert [choice.executor for choice in choices] == ["numpy"] * 3


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
