"""The front: what is on it, what is dominated, and which method is the cheapest within a target."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robodyn.measure.accuracy.ladder import Ladder, Rung, Spread, front, timed


def rung(name: str, error: float, seconds: float) -> Rung:
    return Rung(name, (error,), Spread(seconds, seconds, seconds, 1))


def ladder(*rungs: Rung) -> Ladder:
    return Ladder("task", ("result",), "truth", "mesh", rungs)


FEW = st.integers(0, 6).map(float)
RUNGS = st.lists(st.tuples(FEW, FEW), min_size=1, max_size=12).map(
    lambda pairs: [rung(str(k), error, seconds) for k, (error, seconds) in enumerate(pairs)]
)


@given(RUNGS)
def test_the_front_is_monotone_and_dominates_the_rest(rungs: list[Rung]) -> None:
    best = front(rungs)
    assert all(a.time.median < b.time.median and a.error > b.error for a, b in pairwise(best))
    whole = ladder(*rungs)
    for each in rungs:
        other = whole.dominator(each)
        assert (other is None) == (each in best)
        if other is not None:
            assert other in best
            assert other.time.median <= each.time.median
            assert other.error <= each.error


@given(RUNGS, FEW)
def test_the_cheapest_is_the_quickest_within_the_target(rungs: list[Rung], target: float) -> None:
    within = [each.time.median for each in rungs if each.error <= target]
    found = ladder(*rungs).cheapest(target)
    assert (found is None) == (not within)
    if found is not None:
        assert found.error <= target
        assert found.time.median == min(within)


def test_the_cheapest_by_example() -> None:
    methods = ladder(
        rung("slow", 1e-12, 9.0), rung("rough", 1e-2, 1.0), rung("poor", 1e-5, 8.0), rung("good", 1e-8, 3.0)
    )
    assert [each.name for each in methods.front] == ["rough", "good", "slow"]
    found = [methods.cheapest(target) for target in (1e-1, 1e-6, 1e-8, 1e-10, 1e-13)]
    assert [each and each.name for each in found] == ["rough", "good", "good", "slow", None]
    poor = methods.dominator(methods.rungs[2])
    assert poor is not None
    assert poor.name == "good"


def test_the_largest_error_counts() -> None:
    assert Rung("both", (1e-9, 1e-3), Spread(1.0, 1.0, 1.0, 1)).error == 1e-3


def test_spread_is_median_and_quartiles() -> None:
    assert Spread.of([4.0, 1.0, 2.0, 3.0, 5.0], 0.5) == Spread(1.5, 1.0, 2.0, 5)


def test_what_is_slow_runs_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robodyn.measure.accuracy.ladder.SPREAD_ROUNDS", 2)
    monkeypatch.setattr("robodyn.measure.accuracy.ladder.CACHED", 0.01)
    calls: list[str] = []
    act = {"act": lambda: calls.append("run")}
    assert timed(act)["act"][1].runs == 2
    assert len(calls) == 5  # a short one fills the caches before each
    monkeypatch.setattr("robodyn.measure.accuracy.ladder.CACHED", 0.0)
    assert timed(act)["act"][1].runs == 2
    assert len(calls) == 8
    monkeypatch.setattr("robodyn.measure.accuracy.ladder.SLOW", 0.0)
    assert timed(act)["act"][1].runs == 1
    assert len(calls) == 9
