"""Where machine code cannot be had, NumPy does the work and one warning says so."""

from __future__ import annotations

import warnings
from functools import cache

import numpy as np
import pytest
from helpers.compiled_programs import needs_compiler, program_of

from robodyn.errors import InputError
from robodyn.programs.run import runner
from robodyn.programs.run.llvm import build, machine
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.programs.run.runner import Runner


def _powers(x):
    powers = [x]
    for _ in range(100):
        powers.append(powers[-1] * x)
    return powers[-1:]


PROGRAM = program_of(_powers, 1)
X = np.random.default_rng(3).uniform(-2, 2, (50, 1))
BY_NUMPY = NumpyBlocks(PROGRAM, {"x": 1})({"x": X}, len(X))
HUGE = 10**9


@pytest.fixture(autouse=True)
def fresh(monkeypatch, tmp_path):
    """An empty cache, and nothing said in this process."""
    monkeypatch.setenv("ROBODYN_CACHE", str(tmp_path))
    monkeypatch.setattr(runner, "_say", cache(runner._say.__wrapped__))


def made():
    return Runner(PROGRAM, {"x": 1})


def run(a_runner, **options):
    return a_runner.run({"x": X}, len(X), **options)


def test_processor_without_fused_multiply_add(monkeypatch):
    old = machine.Host("x86_64-unknown-linux-gnu", "sandybridge", "+avx,-fma,-fma4", "0.45", (20,))
    monkeypatch.setattr(machine, "host", lambda: old)
    monkeypatch.setattr(runner, "compiler_problem", machine.compiler_problem.__wrapped__)
    problem = "the processor (sandybridge) has no fused multiply-add"
    _falls_back(made(), problem)


@pytest.mark.parametrize(
    ("features", "triple", "fused"),
    [
        ("+fma", "x86_64-pc", True),
        ("-fma", "x86_64-pc", False),
        ("+fma4", "x86_64-pc", False),
        ("", "arm64-apple", True),
    ],
)
def test_fused_multiply_add_by_processor(features, triple, fused):
    assert machine.Host(triple, "some", features, "0.45", (20,)).fused == fused


@needs_compiler
@pytest.mark.parametrize("failure", [RuntimeError("LLVM ERROR: out of registers\nmore"), OSError("no memory to run")])
def test_llvm_that_fails_on_a_program(monkeypatch, failure):
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
def test_llvmlite_that_does_not_load(monkeypatch, failure):
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


def test_warning_as_an_error_leaves_the_runner_usable(monkeypatch):
    monkeypatch.setattr(runner, "compiler_problem", lambda: "there is none")
    a_runner = made()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(RuntimeWarning, match="there is none"):
            run(a_runner, expected=HUGE)
        np.testing.assert_array_equal(run(a_runner, expected=HUGE).values, BY_NUMPY)
