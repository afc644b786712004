"""How many processes work at a time, and what becomes of errors, of processes that die, and of interruptions."""

from __future__ import annotations

import os

import numpy as np
import pytest
from helpers.processed import figure_of, leave, write_interrupted

from robodyn.checks.sources import each_in_a_process
from robodyn.errors import InputError
from robodyn.support import threads as workers
from robodyn.support.processes import in_processes
from robodyn.support.threads import processes


@pytest.mark.parametrize(
    ("jobs", "asked", "platform", "expected"),
    [(1000, None, "linux", 96), (5, None, "linux", 5), (1000, None, "win32", 61), (1000, 200, "win32", 61)],
)
def test_windows_waits_for_61_processes_at_most(monkeypatch, jobs, asked, platform, expected):
    monkeypatch.setattr(workers, "cores", lambda: 96)
    assert processes(jobs, asked, platform) == expected


def test_a_number_of_threads_is_said_as_it_is_written():
    with pytest.raises(InputError, match=r"^0 threads cannot work"):
        workers.cores(np.int64(0))


def test_files_are_checked_by_as_many(monkeypatch):
    """Under Windows no more can be waited for."""
    counts = []

    def in_turn(work, calls, count):
        counts.append(count)
        yield from ((number, work(*call)) for number, call in reversed([*enumerate(calls)]))

    monkeypatch.setattr("robodyn.support.processes.in_processes", in_turn)
    monkeypatch.setattr("robodyn.checks.sources.processes", lambda jobs: processes(jobs, 96, "win32"))
    assert list(each_in_a_process(lambda file: file, [(k,) for k in range(80)])) == list(range(80))
    assert counts == [61]


def test_what_is_raised_is_raised_here(children):
    with pytest.raises(InputError, match="no figure: 'x'") as raised:
        list(in_processes(figure_of, [("1",), ("x",)], 1))
    assert "in figure_of" in str(raised.value.__cause__)
    assert all(child.returncode is not None for child in children)


def test_a_call_that_ends_its_processes_stops_no_other(children):
    """It is tried again, and then given up."""
    found = dict(in_processes(leave, [(0,), (7,), (0,)], 2))
    assert (found[0], found[2]) == (0, 0)
    assert str(found[1]) == "its process died 2 times, at last by status 7 (is there enough memory?)"
    (_, outcome) = each_in_a_process(leave, [(0,), (7,)])
    assert isinstance(outcome, InputError)
    assert all(child.returncode is not None for child in children)


@pytest.mark.skipif(os.name != "posix", reason="needs signals")
def test_processes_get_no_interruption():
    """Nor does polars, which handles the signal even of a process that ignores it, and raises KeyboardInterrupt."""
    assert list(in_processes(write_interrupted, [()], 1)) == [(0, "written")]
