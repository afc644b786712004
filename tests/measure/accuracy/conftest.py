"""Times of ladders are not what is tested: each method runs twice and no longer."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True)
def _few_rounds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robodyn.measure.accuracy.ladder.SPREAD_BUDGET", 0.0)
    monkeypatch.setattr("robodyn.measure.accuracy.ladder.SPREAD_ROUNDS", 2)
