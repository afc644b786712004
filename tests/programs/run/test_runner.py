"""Which executor does the work: the quicker one, the one that is asked for, and NumPy where machine code fails."""

from __future__ import annotations

import warnings
from functools import cache

import numpy as np
import pytest
from helpers.compiled_programs import needs_compiler, program_of

from robodyn.errors import InputError
from robodyn.programs.run import runner
from robodyn.programs.run.compiled_blocks import CompiledBlocks
from robodyn.programs.run.llvm import build, machine
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.programs.run.runner import BUILD, CALL, COMPILED, NUMPY, RUN, START, Runner, Work, choice

HUGE = 10**9


def _sums(x, y):
    for _ in range(100):
        x, y = x * y, x * 0.5 + y
    return [x.sin(), y]


PROGRAM = program_of(_sums, 2)
X = np.random.default_rng(3).uniform(-2, 2, (50, 2))
BY_NUMPY = NumpyBlocks(PROGRAM, {"x": 2})({"x": X}, len(X))


@pytest.fixture
def fresh(monkeypatch, tmp_path):
    """An empty cache, and nothing said in this process."""
    monkeypatch.setenv("ROBODYN_CACHE", str(tmp_path))
    monkeypatch.setattr(runner, "_say", cache(runner._say.__wrapped__))


def made():
    return Runner(PROGRAM, {"x": 2})


def run(a_runner, **options):
    return a_runner.run({"x": X.astype(options.get("dtype", np.float64))}, len(X), **options)


def chosen(work):
    return choice(work).executor


def test_machine_code_from_the_crossing_on():
    """The most samples in one block for which NumPy is the quicker, from the rates."""
    operations = 1024
    work = Work(operations, 0, 1, 1)
    last = int((RUN + START + operations * (BUILD - CALL)) / (operations * (NUMPY - COMPILED)))
    assert chosen(work._replace(samples=last - 1)) == "numpy"
    assert chosen(work._replace(samples=last + 2)) == "compiled"


def test_reasons_name_the_work():
    assert chosen(Work(1000, 0, 0, 0)) == "numpy", "no samples"
    assert chosen(Work(5, 10**7, 10**7, 10**7)) == "numpy", "calls of next to nothing are never worth it"
    assert choice(Work(444, 10, 1, 1)) == ("numpy", "little work, and it starts at once")
    assert choice(Work(444, 10**5, 1, 1)) == (
        "numpy",
        "100000 samples of 444 operations are done before machine code could be ready",
    )
    assert choice(Work(444, 10**7, 1, 1)) == ("compiled", "10000000 samples of 444 operations are worth machine code")


@needs_compiler
def test_much_work_is_done_by_machine_code(fresh):
    a_runner = made()
    found = run(a_runner, expected=HUGE)
    assert not a_runner._numpy, "its steps are laid out only where NumPy may be chosen"
    np.testing.assert_array_equal(found.values, CompiledBlocks(PROGRAM, {"x": 2})({"x": X}, len(X)))
    assert found.choice == ("compiled", "1000000000 samples of 301 operations are worth machine code")


@needs_compiler
def test_explicit_executors_do_not_decide_for_the_others(fresh):
    a_runner = made()
    for executor, expected in (("compiled", "compiled"), ("numpy", "numpy"), ("auto", "compiled")):
        assert run(a_runner, executor=executor).choice.executor == expected
    found = run(a_runner, dtype=np.float32)
    assert found.choice.executor == "numpy", "there is no machine code for this format yet"
    assert run(a_runner).choice.executor == "compiled"


@needs_compiler
def test_small_calls_turn_to_machine_code_once_it_would_have_paid(fresh):
    """As `choice` has it for all samples so far."""
    executors = [choice(Work(PROGRAM.size, 50 * k, k, k)).executor for k in range(1, 1000)]
    turn = executors.index("compiled")
    a_runner = made()
    assert [run(a_runner).choice.executor for _ in executors[: turn + 3]] == executors[: turn + 3]


@needs_compiler
@pytest.mark.parametrize("expected", [1000, HUGE])
def test_announced_work_is_done_the_same_way_whatever_came_before(fresh, expected):
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


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("compield", "did you mean 'compiled'?"),
        ("gpu", "executors: 'auto', 'numpy', 'compiled'"),
        (7, "executors: "),
    ],
)
def test_executor_that_does_not_exist(fresh, name, remedy):
    with pytest.raises(InputError) as error:
        run(made(), executor=name)
    assert str(error.value).startswith(f"there is no executor {name!r} ({remedy}")


@pytest.mark.parametrize("executor", ["auto", "numpy", "compiled"])
def test_threads_that_cannot_work(executor):
    with pytest.raises(InputError, match=r"-1 threads cannot work \(1 or more\)"):
        run(made(), executor=executor, threads=-1)


def test_processor_without_fused_multiply_add(fresh, monkeypatch):
    old = machine.Host("x86_64-unknown-linux-gnu", "sandybridge", "+avx,-fma,-fma4", "0.45", (20,))
    monkeypatch.setattr(machine, "host", lambda: old)
    monkeypatch.setattr(runner, "compiler_problem", machine.compiler_problem.__wrapped__)
    problem = "the processor (sandybridge) has no fused multiply-add"
    _falls_back(made(), problem)


@needs_compiler
@pytest.mark.parametrize("failure", [RuntimeError("LLVM ERROR: out of registers\nmore"), OSError("no memory to run")])
def test_llvm_that_fails_on_a_program(fresh, monkeypatch, failure):
    attempts = []

    def machine_code(_):
        attempts.append(failure)
        raise failure

    monkeypatch.setattr(build, "machine_code", machine_code)
    a_runner = made()
    _falls_back(a_runner, f"LLVM fails on this program ({str(failure).splitlines()[0]})")
    before = len(attempts)
    run(a_runner, expected=HUGE)
    assert len(attempts) == before, "it is not tried again and again"


@pytest.mark.parametrize("failure", [OSError("libLLVM.so: cannot open\nmore"), RuntimeError("bad"), ImportError("bad")])
def test_llvmlite_that_does_not_load(fresh, monkeypatch, failure):
    def host():
        raise failure

    monkeypatch.setattr(machine, "host", host)
    monkeypatch.setattr(runner, "compiler_problem", machine.compiler_problem.__wrapped__)
    _falls_back(made(), f"llvmlite does not load ({str(failure).splitlines()[0]}); pip install llvmlite")


def _falls_back(a_runner, problem):
    """Large work runs by NumPy and says why once; asking for machine code is an error."""
    with pytest.warns(RuntimeWarning) as said:
        found = run(a_runner, expected=HUGE)
    np.testing.assert_array_equal(found.values, BY_NUMPY)
    assert [str(warning.message) for warning in said] == [
        f"large work goes without machine code, tens of times slower: {problem}"
    ]
    assert found.choice == ("numpy", problem)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for other in (a_runner, made()):
            np.testing.assert_array_equal(run(other, expected=HUGE).values, BY_NUMPY)
    with pytest.raises(InputError) as error:
        run(made(), executor="compiled")
    assert str(error.value) == f"the compiled executor cannot run: {problem} (choose auto or numpy)"


def test_warning_as_an_error_leaves_the_runner_usable(fresh, monkeypatch):
    monkeypatch.setattr(runner, "compiler_problem", lambda: "there is none")
    a_runner = made()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(RuntimeWarning, match="there is none"):
            run(a_runner, expected=HUGE)
        np.testing.assert_array_equal(run(a_runner, expected=HUGE).values, BY_NUMPY)
