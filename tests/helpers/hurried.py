"""Measurements as short as can be, for what is measured does not matter in tests; and an end of what waits for ever."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from robodyn.measure.accuracy import ladder as timing

ONE_RUN = {"SPREAD_BUDGET": 0.0, "SPREAD_ROUNDS": 1, "CACHED": 0.0}


def hurry(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have everything that is timed run once, in one round."""
    for name, value in ONE_RUN.items():
        monkeypatch.setattr(timing, name, value)


class Waits(BaseException):
    """What is done does not end; no error, which a command would tell as its own."""


@contextmanager
def hurried(seconds: int = 60) -> Iterator[None]:
    """Fail what waits without end."""

    def late(*_: object) -> None:
        raise Waits

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
