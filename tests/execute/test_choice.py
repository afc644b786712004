"""Which executor suits which work: the quicker one by the rates, and more work never suits NumPy better."""

from __future__ import annotations

from dataclasses import asdict, astuple, replace

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from robodyn.execute.choice import TYPICAL, Rates, Readiness, Work, choice, times

COLD, WARM = Readiness(kept=False, started=False), Readiness(kept=True, started=True)
SIMPLE = Rates(*(2.0**power for power in (-20, -28, -16, -32, -14, -9, -4)))
SANE = st.tuples(*(st.floats(-2.9, 2.9).map(lambda power: 10.0**power) for _ in astuple(TYPICAL))).map(
    lambda factors: Rates(*(factor * rate for factor, rate in zip(factors, astuple(TYPICAL), strict=True)))
)
READY = st.builds(Readiness, kept=st.booleans(), started=st.booleans())
COUNT = st.integers(1, 10**6)


@st.composite
def works(draw):
    runs = draw(st.integers(1, 1000))
    return Work(draw(COUNT), draw(COUNT) * runs, runs, runs * draw(st.integers(1, 50)), draw(st.integers(1, 64)))


def chosen(work, ready, rates):
    return choice(work, ready, rates).executor


def _crossing(ready, work):
    """The most samples in one block for which NumPy is the quicker."""
    operations, rates = work.operations, SIMPLE
    begin = rates.run + (0.0 if ready.started else rates.start)
    build = rates.build * operations
    begin += rates.load if ready.kept else build
    return (begin - operations * rates.call) / (operations * (rates.numpy - rates.compiled / work.threads))


@pytest.mark.parametrize("threads", [1, 16])
@pytest.mark.parametrize("operations", [64, 1024])
@pytest.mark.parametrize("ready", [COLD, WARM, COLD._replace(kept=True), COLD._replace(started=True)])
def test_machine_code_from_the_crossing_on(ready, operations, threads):
    work = Work(operations, 0, 1, 1, threads)
    last = int(_crossing(ready, work))
    assert chosen(work._replace(samples=max(last - 1, 0)), ready, SIMPLE) == "numpy"
    assert chosen(work._replace(samples=max(last + 2, 0)), ready, SIMPLE) == "compiled"


def test_work_of_no_samples_is_left_to_numpy():
    assert chosen(Work(1000, 0, 0, 0, 2), WARM, TYPICAL) == "numpy"


@settings(deadline=None)
@given(rates=SANE, work=works(), ready=READY, more=COUNT)
def test_more_samples_never_turn_machine_code_into_numpy(rates, work, ready, more):
    assume(rates.sane)
    larger = work._replace(samples=work.samples + more, blocks=work.blocks + more // 4096)
    assert (chosen(work, ready, rates), chosen(larger, ready, rates)) != ("compiled", "numpy")


@settings(deadline=None)
@given(rates=SANE, work=works(), more=st.integers(1, 64))
def test_neither_do_more_threads_or_code_that_is_there(rates, work, more):
    assume(rates.sane and rates.load < work.operations * rates.build)
    before = chosen(work, COLD, rates)
    assert (before, chosen(work._replace(threads=work.threads + more), COLD, rates)) != ("compiled", "numpy")
    assert (before, chosen(work, COLD._replace(started=True), rates)) != ("compiled", "numpy")
    assert (before, chosen(work, COLD._replace(kept=True), rates)) != ("compiled", "numpy")


def test_small_calls_are_worth_machine_code_in_the_end():
    """One sample at a time: the time that each call of NumPy takes adds up to that of making the code."""
    calls = [Work(500, k, k, k, 1) for k in range(1, 2000)]
    executors = [chosen(work, COLD, TYPICAL) for work in calls]
    turn = executors.index("compiled")
    assert set(executors[turn:]) == {"compiled"}
    by_numpy, by_code = times(calls[turn], COLD, TYPICAL)
    assert by_code < by_numpy < by_code + 500 * (TYPICAL.call + TYPICAL.numpy)


def test_calls_of_next_to_nothing_are_never_worth_it():
    assert chosen(Work(5, 10**7, 10**7, 10**7, 1), COLD, TYPICAL) == "numpy"


def test_reasons_name_the_work():
    assert choice(Work(444, 10, 1, 1, 1), COLD, TYPICAL) == (
        "numpy",
        "10 samples of 444 operations are done before machine code could be ready",
    )
    assert choice(Work(444, 10**7, 1, 1, 1), COLD, TYPICAL) == (
        "compiled",
        "10000000 samples of 444 operations are worth machine code",
    )


@pytest.mark.parametrize("field", asdict(TYPICAL))
@pytest.mark.parametrize("value", [0.0, -1e-6, float("nan"), float("inf"), 1e-300, 1e9])
def test_rates_that_no_machine_has(field, value):
    assert TYPICAL.sane
    assert not replace(TYPICAL, **{field: value}).sane


def test_machine_code_slower_than_numpy_is_no_rate_to_choose_by():
    assert not replace(TYPICAL, compiled=TYPICAL.numpy).sane
