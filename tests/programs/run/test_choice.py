"""Which executor suits which work: the quicker one, and more work never suits NumPy better."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robodyn.programs.run.runner import BUILD, CALL, COMPILED, NUMPY, RUN, START, Work, choice, times

COUNT = st.integers(1, 10**6)


@st.composite
def works(draw):
    runs = draw(st.integers(1, 1000))
    return Work(draw(COUNT), draw(COUNT) * runs, runs, runs * draw(st.integers(1, 50)))


def chosen(work):
    return choice(work).executor


@pytest.mark.parametrize("operations", [64, 1024])
def test_machine_code_from_the_crossing_on(operations):
    """The most samples in one block for which NumPy is the quicker, from the rates."""
    work = Work(operations, 0, 1, 1)
    last = int((RUN + START + operations * (BUILD - CALL)) / (operations * (NUMPY - COMPILED)))
    assert chosen(work._replace(samples=last - 1)) == "numpy"
    assert chosen(work._replace(samples=last + 2)) == "compiled"


def test_work_of_no_samples_is_left_to_numpy():
    assert chosen(Work(1000, 0, 0, 0)) == "numpy"


@given(work=works(), more=COUNT)
def test_more_samples_never_turn_machine_code_into_numpy(work, more):
    larger = work._replace(samples=work.samples + more, blocks=work.blocks + more // 4096)
    assert (chosen(work), chosen(larger)) != ("compiled", "numpy")


def test_small_calls_are_worth_machine_code_in_the_end():
    """One sample at a time: the time that each call of NumPy takes adds up to that of making the code."""
    calls = [Work(500, k, k, k) for k in range(1, 2000)]
    executors = [chosen(work) for work in calls]
    turn = executors.index("compiled")
    assert set(executors[turn:]) == {"compiled"}
    by_numpy, by_code = times(calls[turn])
    assert by_code < by_numpy < by_code + 500 * (CALL + NUMPY)


def test_calls_of_next_to_nothing_are_never_worth_it():
    assert chosen(Work(5, 10**7, 10**7, 10**7)) == "numpy"


def test_reasons_name_the_work():
    assert choice(Work(444, 10, 1, 1)) == ("numpy", "little work, and it starts at once")
    assert choice(Work(444, 10**5, 1, 1)) == (
        "numpy",
        "100000 samples of 444 operations are done before machine code could be ready",
    )
    assert choice(Work(444, 10**7, 1, 1)) == (
        "compiled",
        "10000000 samples of 444 operations are worth machine code",
    )
