"""How many processes work at a time."""

from __future__ import annotations

import pytest

from robodyn.checks.sources import each_in_a_process
from robodyn.support import threads as workers
from robodyn.support.threads import processes


@pytest.mark.parametrize(
    ("jobs", "asked", "platform", "expected"),
    [
        (1000, None, "linux", 96),
        (1000, 200, "linux", 200),
        (5, None, "linux", 5),
        (5, 200, "linux", 5),
        (1000, None, "win32", 61),
        (1000, 200, "win32", 61),
        (1000, 7, "win32", 7),
        (5, None, "win32", 5),
    ],
)
def test_windows_waits_for_61_processes_at_most(monkeypatch, jobs, asked, platform, expected):
    monkeypatch.setattr(workers, "cores", lambda: 96)
    assert processes(jobs, asked, platform) == expected


def test_files_are_checked_by_as_many(monkeypatch):
    """The pool itself refuses more under Windows."""
    counts = []

    class Pool:
        def __init__(self, count):
            counts.append(count)

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        map = map

    monkeypatch.setattr("concurrent.futures.ProcessPoolExecutor", Pool)
    monkeypatch.setattr("robodyn.checks.sources.processes", lambda jobs: processes(jobs, 96, "win32"))
    assert list(each_in_a_process(lambda file, _: file, range(80), None)) == list(range(80))
    assert counts == [61]
