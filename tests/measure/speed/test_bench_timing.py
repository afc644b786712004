"""Time as benchmarks measure it, by a clock that the tests turn."""

from __future__ import annotations

import numpy as np
import pytest

from robodyn.measure import timing as bench_timing
from robodyn.measure.speed.result import Timing
from robodyn.measure.timing import ROUNDS, Copying, largest_difference, repeated, taking_turns

BUDGET, SHORT, TURN = 1.0, 0.25, 0.03125


class Clock:
    """Seconds that pass only where a test says so."""

    def __init__(self) -> None:
        self.now = 0.0
        self.acts: list[str] = []

    def act(self, name, *seconds):
        """Something that takes these seconds, one after another, the last of them ever after."""
        left = list(seconds)

        def run():
            self.acts.append(name)
            self.now += left.pop(0) if len(left) > 1 else left[0]

        return run


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    for name, seconds in (("BUDGET", BUDGET), ("SHORT", SHORT), ("TURN", TURN)):
        monkeypatch.setattr(bench_timing, name, seconds)
    monkeypatch.setattr(bench_timing, "ROUNDS", ROUNDS)
    monkeypatch.setattr(bench_timing, "perf_counter", lambda: clock.now)
    return clock


def test_shortest_and_median_without_the_first_round(clock):
    found = taking_turns({"a": clock.act("a", 99.0, 4.0, 1.0, 2.5), "b": clock.act("b", 99.0, 1.0)})
    assert ROUNDS == 3
    assert found == {"a": Timing(1.0, 2.5, 3), "b": Timing(1.0, 1.0, 3)}
    assert clock.acts == ["a", "b"] * 4


def test_what_is_short_runs_for_its_whole_turn(clock):
    short = TURN / 4
    found = taking_turns({"long": clock.act("long", BUDGET), "short": clock.act("short", short)})
    assert found["long"].runs == ROUNDS
    assert found["short"].runs == 4 * ROUNDS
    assert found["short"].least == short


def test_rounds_go_on_for_the_budget(clock):
    found = taking_turns({"": clock.act("", BUDGET / 16)})[""]
    assert found.runs == 16


def test_what_takes_long_to_make_is_made_once(clock):
    assert repeated(clock.act("", 2 * SHORT)).runs == 1
    assert clock.acts == [""]
    assert repeated(clock.act("", SHORT / 4)).runs == 4


def test_times_of_one_sample():
    assert Timing(3.0, 6.0, 7).per(3) == Timing(1.0, 2.0, 7)


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_all_is_copied(threads):
    copying = Copying(16 * 1001)
    copying.source[:] = np.arange(1001)
    copying(threads)
    assert np.array_equal(copying.target, np.arange(1001))


def test_difference_is_of_the_largest_expected():
    assert largest_difference(np.array([1.0, -3.0]), np.array([2.0, -4.0])) == 0.25
    assert largest_difference(np.zeros(2), np.zeros(2)) == 0.0
