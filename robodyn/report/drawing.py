"""Figures that are drawn at once, or by processes beside this one while it has other work."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from importlib import import_module
from threading import active_count
from typing import Any, Protocol

PROCESSES = 2
_MODULES = ("matplotlib.figure", "matplotlib.backends.backend_svg", "robodyn.report.figures_torques")


class Draw(Protocol):
    """Begin to draw: a function and what it is called with."""

    def __call__(self, function: Callable[..., Any], *given: Any) -> Callable[[], Any]:
        """What returns the result, when it is wanted."""
        ...


def at_once(function: Callable[..., Any], *given: Any) -> Callable[[], Any]:
    """In this process, when the result is wanted."""
    return partial(function, *given)


@contextmanager
def beside() -> Iterator[Draw]:
    """In processes beside this one, which import what draws from now on; in this one where there can be none."""
    from concurrent.futures import ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import get_context

    def draw(function: Callable[..., Any], *given: Any) -> Callable[[], Any]:
        try:
            waiting = pool.submit(function, *given)
        except (OSError, RuntimeError):
            return partial(function, *given)

        def result() -> Any:
            with suppress(BrokenProcessPool, OSError):
                return waiting.result()
            return function(*given)

        return result

    try:
        how = "fork" if sys.platform == "linux" and active_count() == 1 else "spawn"
        pool = ProcessPoolExecutor(PROCESSES, get_context(how), _prepare)
        for _ in range(PROCESSES):
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
    for name in _MODULES:
        with suppress(ImportError):
            import_module(name)
