"""Measurements in tests: as short as can be, for what is measured does not matter there."""

from __future__ import annotations

import pytest

from robodyn.measure.accuracy import ladder as timing

ONE_RUN = {"SPREAD_BUDGET": 0.0, "SPREAD_ROUNDS": 1, "CACHED": 0.0}


def hurry(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have everything that is timed run once, in one round."""
    for name, value in ONE_RUN.items():
        monkeypatch.setattr(timing, name, value)
