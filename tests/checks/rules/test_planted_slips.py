"""Slips of people, drawn by chance in published robots, are named, but for those that are known to go unseen."""

from __future__ import annotations

import pytest
from helpers.planted_slips import FILE, HARMLESS, NAMED, Slip, by_its_rule, outcome, slips
from helpers.sampled import sampled

UNSEEN = (FILE.parent / "unseen_slips.txt").read_text(encoding="utf-8").splitlines()
"""Slips that are not named so far; `benchmarks.bench_slips --unseen 1` writes them."""
ALL = slips()


@pytest.mark.parametrize("slip", sampled([slip for slip in ALL if str(slip) not in UNSEEN], 80), ids=str)
def test_named(slip: Slip) -> None:
    if slip.group == HARMLESS:
        assert not outcome(slip).elsewhere
    else:
        assert by_its_rule(slip).verdict == NAMED


def test_many_kinds_in_three_robots_and_most_named() -> None:
    kinds = {slip.kind for slip in ALL if slip.group != HARMLESS}
    robots = {kind: {slip.robot for slip in ALL if slip.kind == kind} for kind in kinds}
    assert sum(len(each) >= 3 for each in robots.values()) >= 160
    assert len(UNSEEN) < 0.12 * len(ALL)
    assert set(UNSEEN) <= {str(slip) for slip in ALL}
