"""How many processes work at a time, and what becomes of errors, of processes that die, and of interruptions; threads
that read ahead and write behind; what is done about messages of other libraries is done in one thread, and undone."""

from __future__ import annotations

import logging
import os
import threading
import warnings
from collections.abc import Iterator
from threading import Event, Thread

import numpy as np
import pytest
from helpers.mesh_files import dae
from helpers.processed import figure_of, leave, write_interrupted

from robodyn.errors import InputError
from robodyn.solids.mesh.read.load import load_triangles
from robodyn.support import threads as workers
from robodyn.support.libraries import library_messages, treated_warnings
from robodyn.support.processes import each_in_a_process, in_processes
from robodyn.support.threads import prefetch, processes, write_behind


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
    monkeypatch.setattr("robodyn.support.processes.processes", lambda jobs: processes(jobs, 96, "win32"))
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


def counted(stop: int, made: list[int]) -> Iterator[int]:
    for i in range(stop):
        made.append(i)
        yield i


def test_ahead_gives_the_same_items_in_order_and_what_they_raise() -> None:
    def failing() -> Iterator[int]:
        yield 1
        raise ValueError("second")

    assert list(prefetch(iter(range(100)))) == list(range(100))
    assert list(prefetch(iter(()))) == []
    items = prefetch(failing())
    assert next(items) == 1
    with pytest.raises(ValueError, match="second"):
        next(items)


def test_ahead_holds_few_items_and_ends_its_thread_when_it_is_left_early() -> None:
    made: list[int] = []
    before = threading.active_count()
    items = prefetch(counted(1000, made))
    assert next(items) == 0
    items.close()  # type: ignore[attr-defined]
    assert threading.active_count() == before
    assert len(made) <= 5


def test_behind_uses_everything_in_order_before_it_ends() -> None:
    used: list[int] = []
    with write_behind(used.append) as call:
        for i in range(100):
            call(i)
    assert used == list(range(100))


def test_behind_raises_a_failure_and_uses_nothing_after_it() -> None:
    used: list[int] = []

    def use(i: int) -> None:
        if i == 3:
            raise OSError("disk full")
        used.append(i)

    def run() -> None:
        with write_behind(use) as call:
            for i in range(100):
                call(i)

    with pytest.raises(OSError, match="disk full"):
        run()
    assert used == [0, 1, 2]


NAME = "robodyn.tests.library"


@pytest.fixture(autouse=True)
def _as_it_was():
    loggers = [logging.getLogger(name) for name in (NAME, "trimesh", "yourdfpy")]
    before = [(logger.disabled, logger.level, list(logger.filters), list(logger.handlers)) for logger in loggers]
    yield
    assert [(logger.disabled, logger.level, logger.filters, logger.handlers) for logger in loggers] == before


def test_messages_of_this_thread_are_heard_and_those_of_others_go_on(caplog):
    logger = logging.getLogger(NAME)
    with caplog.at_level(logging.INFO):
        with library_messages(NAME) as messages:
            logger.warning("of %s", "ours")
            logger.info("little")
            other = Thread(target=lambda: logger.warning("of another"))
            other.start()
            other.join()
        logger.error("later")
    assert messages == ["of ours"]
    assert [record.message for record in caplog.records] == ["little", "of another", "later"]


def test_filters_of_warnings_are_restored_whoever_ends_first():
    """If both were at it, the one who began first would put back what he found, the other then the first one's."""
    before = list(warnings.filters)
    begun, both, ended = Event(), Event(), Event()

    def first():
        with treated_warnings("error", "one"):
            begun.set()
            both.wait(0.1)
        ended.set()

    thread = Thread(target=first)
    thread.start()
    begun.wait()
    with treated_warnings("ignore", "two"):
        both.set()
        ended.wait()
    thread.join()
    assert warnings.filters == before


def test_a_scene_is_read_while_others_log(tmp_path, monkeypatch, caplog):
    from trimesh.exchange.load import mesh_loaders

    def load(*given, **more):
        other = Thread(target=lambda: logging.getLogger("trimesh").warning("of another"))
        other.start()
        other.join()
        logging.getLogger("trimesh.util").warning("ours")
        return before(*given, **more)

    before = mesh_loaders["dae"]
    monkeypatch.setitem(mesh_loaders, "dae", load)
    found = load_triangles(dae(np.eye(3)[None]), file_type="dae")
    assert "trimesh: ours" in found.notes
    assert [record.message for record in caplog.records] == ["of another"]
