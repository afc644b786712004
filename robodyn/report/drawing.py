"""Figures that are drawn at once, or by processes beside this one while it has other work."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from importlib import import_module
from threading import active_count
from typing import Any

PROCESSES = 2
_MODULES = ("matplotlib.figure", "matplotlib.backends.backend_svg", "robodyn.report.figures_torques")

Task = Callable[[], Any]
"""What draws something and returns it."""
Draw = Callable[[Sequence[Task]], Sequence[Task]]
"""Begin with tasks; for each, what returns its result when it is wanted."""


def at_once(tasks: Sequence[Task]) -> Sequence[Task]:
    """In this process, when the results are wanted."""
    return tasks


@contextmanager
def beside() -> Iterator[Draw]:
    """In processes beside this one; in this one where there can be none.

    The first of them begins to import what draws now, and parts into PROCESSES when there are tasks: an import takes
    as long as half of a report's figures.
    """
    from concurrent.futures import ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import get_context

    def draw(tasks: Sequence[Task]) -> Sequence[Task]:
        try:
            waiting = pool.submit(_drawn, tasks)
        except (OSError, RuntimeError):
            return tasks

        def result(k: int) -> Any:
            with suppress(BrokenProcessPool, OSError):
                return waiting.result()[k]
            return tasks[k]()

        return [partial(result, k) for k in range(len(tasks))]

    try:
        how = "fork" if sys.platform == "linux" and active_count() == 1 else "spawn"
        pool = ProcessPoolExecutor(1, get_context(how), _prepare)
        pool.submit(int)
    except (ImportError, OSError):
        yield at_once
        return
    try:
        yield draw
    finally:
        pool.shutdown(cancel_futures=True)


def _prepare() -> None:
    """Import what draws; an interrupt is for the process that asked."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    with suppress(ImportError):
        for name in _MODULES:
            import_module(name)
        from robodyn.report.figures_torques import first_figure

        first_figure()


def _drawn(tasks: Sequence[Task]) -> list[Any]:
    """The results, by processes that have what this one has imported, where there can be such."""
    if sys.platform != "linux":
        return [task() for task in tasks]
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    with ProcessPoolExecutor(PROCESSES, get_context("fork")) as pool:
        waiting = [pool.submit(task) for task in tasks]
        return [each.result() for each in waiting]
