"""Benchmarks in tests: every measurement as short as can be, for what is measured does not matter there."""

from __future__ import annotations

import pytest

from robodyn.measure import timing as bench_timing


def hurry(monkeypatch: pytest.MonkeyPatch) -> None:
    """One run in one round of everything."""
    for name in ("BUDGET", "SHORT", "TURN"):
        monkeypatch.setattr(bench_timing, name, 0.0)
    monkeypatch.setattr(bench_timing, "ROUNDS", 1)
