"""How many threads and processes work at a time; reading ahead and writing behind in threads of their own."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from queue import Queue
from threading import Thread
from typing import Any, TypeVar

from robodyn.errors import InputError

Item = TypeVar("Item")
Result = TypeVar("Result")
_END = object()


def cores(asked: int | None = None) -> int:
    """Return the number of threads asked for, a whole one from 1 on; None is as many as the process may use cores."""
    if asked is not None:
        if not hasattr(asked, "__index__"):
            raise InputError(f"{asked!r} threads cannot work", remedy="a whole number")
        if asked < 1:
            raise InputError(f"{asked} threads cannot work", remedy="1 or more")
        return asked
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


def processes(jobs: int, asked: int | None = None, platform: str = sys.platform) -> int:
    """Return how many processes do some jobs: those asked for, or one for each core, as far as the system can."""
    most = 61 if platform == "win32" else jobs  # so many one process can wait for
    return min(asked or cores(), jobs, most)


def in_threads(work: Callable[[Item], Result], items: Iterable[Item], threads: int | None = None) -> list[Result]:
    """Return `work(item)` of every item, in their order, by so many threads; None is one for each processor."""
    if threads == 1:
        return list(map(work, items))
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        return list(pool.map(work, items))


def prefetch(items: Iterator[Item]) -> Iterator[Item]:
    """Yield the same items, each made while the one before is used; without `concurrent.futures`, whose import takes 15
    ms."""
    ready: Queue[Any] = Queue(maxsize=1)
    wanted = True

    def make() -> None:
        error: BaseException | None = None
        try:
            for item in items:
                ready.put((item, None))
                if not wanted:
                    return
        except BaseException as failure:
            error = failure
        ready.put((_END, error))

    maker = Thread(target=make, daemon=True)
    maker.start()
    try:
        while (got := ready.get())[0] is not _END:
            yield got[0]
        if got[1] is not None:
            raise got[1]
    finally:
        wanted = False
        while maker.is_alive():
            if not ready.empty():
                ready.get()
            maker.join(0.01)


@contextmanager
def write_behind(use: Callable[..., None]) -> Iterator[Callable[..., None]]:
    """Yield a function that lets `use` run later, in order; what it raises is raised by a later call or at the end."""
    waiting: Queue[Any] = Queue(maxsize=1)
    failures: list[BaseException] = []

    def work() -> None:
        while (arguments := waiting.get()) is not _END:
            try:
                if not failures:
                    use(*arguments)
            except BaseException as error:
                failures.append(error)

    def call(*arguments: Any) -> None:
        if failures:
            raise failures[0]
        waiting.put(arguments)

    worker = Thread(target=work, daemon=True)
    worker.start()
    try:
        yield call
    finally:
        waiting.put(_END)
        worker.join()
    if failures:
        raise failures[0]
