"""What other libraries log and warn of while they work for robodyn, and for no other thread."""

from __future__ import annotations

import logging
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal

_WARNINGS = threading.RLock()
"""Filters of warnings belong to the process: who changes them at the same time may leave them changed."""
_FILTERS = threading.Lock()
"""Lists of filters are replaced, not changed: another thread may be going through them."""


class _OwnThread(logging.Filter):
    """Keeps warnings and errors of the thread that made it from going on, and notes them."""

    def __init__(self) -> None:
        super().__init__()
        self.messages: list[str] = []
        self._thread = threading.get_ident()

    def filter(self, record: logging.LogRecord) -> bool:
        if record.thread != self._thread or record.levelno < logging.WARNING:
            return True
        self.messages.append(record.getMessage())
        return False


@contextmanager
def heard(*names: str) -> Iterator[list[str]]:
    """Return what loggers, and those below them, get from this thread as warnings or errors; it goes nowhere else.

    Loggers are as they were for all other threads.
    """
    below = tuple(f"{name}." for name in names)
    known = [name for name in list(logging.root.manager.loggerDict) if name.startswith(below)]
    own, loggers = _OwnThread(), [logging.getLogger(name) for name in {*names, *known}]
    with _FILTERS:
        for logger in loggers:
            logger.filters = [*logger.filters, own]
    try:
        yield own.messages
    finally:
        with _FILTERS:
            for logger in loggers:
                logger.filters = [each for each in logger.filters if each is not own]


@contextmanager
def treated_warnings(action: Literal["ignore", "error"], message: str) -> Iterator[None]:
    """Ignore warnings of this beginning, or raise them; one thread of robodyn after another."""
    with _WARNINGS, warnings.catch_warnings():
        warnings.filterwarnings(action, message=message)
        yield
