"""Which libraries are installed, whether they load (tried in a process of its own), and what they log and warn of."""

from __future__ import annotations

import gc
import json
import logging
import os
import subprocess
import threading
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Literal, NamedTuple

from robodyn.support.children import start_python
from robodyn.support.extras import Library
from robodyn.support.threads import cores

_LONGEST = 60.0
"""Seconds that all of them may take."""
_PROCESSES = 4
"""More would not end sooner than that with the slowest library."""
_MARK = "\x1e"
"""Before an answer, for modules may print too."""
_WARNINGS = threading.RLock()
"""Filters of warnings belong to the process: who changes them at the same time may leave them changed."""
_FILTERS = threading.Lock()
"""Lists of filters are replaced, not changed: another thread may be going through them."""


class Installed(NamedTuple):
    """The version, None where it is not installed; and why it does not load, empty if it does."""

    version: str | None
    problem: str


def installed(libraries: Sequence[Library]) -> dict[str, Installed]:
    """Version and problem of each library, by its name; each process loads several that follow each other."""
    from concurrent.futures import ThreadPoolExecutor

    versions = {library.name: version_of(library.name) for library in libraries}
    there = [library.module for library in libraries if versions[library.name] is not None]
    share = -(-len(there) // min(_PROCESSES, cores())) or 1
    with ThreadPoolExecutor(_PROCESSES) as pool:
        parts = pool.map(lambda k: list(loading(there[k : k + share])), range(0, len(there), share))
        problems = dict(pair for part in parts for pair in part)
    return {each.name: Installed(versions[each.name], problems.get(each.module, "")) for each in libraries}


def version_of(name: str) -> str | None:
    """Return the version that is installed; None where it is not."""
    with suppress(PackageNotFoundError):
        return version(name)
    return None


def loading(modules: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield each module with the reason why it does not load, empty if it does: one process imports them in turn; where
    it ends before the last, the next one has ended it, and another goes on."""
    waiting = list(modules)
    folder = os.path.dirname(os.__file__)  # for processes that libraries start as they are imported
    while waiting:
        with start_python(f"{__name__}:import_each", *waiting, folder=folder, stderr=subprocess.DEVNULL) as process:
            try:
                said, _ = process.communicate(timeout=_LONGEST)
                status = process.returncode
                ended = f"it ends the process, {f'signal {-status}' if status < 0 else f'exit status {status}'}"
            except subprocess.TimeoutExpired:
                process.kill()
                said, ended = process.communicate()[0], f"it does not end within {_LONGEST:.0f} s"
        for line in said.decode(errors="replace").split("\n"):
            if waiting and _MARK in line:
                yield waiting.pop(0), json.loads(line.rpartition(_MARK)[2])
        if waiting:
            yield waiting.pop(0), ended


def import_each(*modules: str) -> None:
    """Print of each module why it cannot be imported, in a process that may end of it."""
    gc.disable()  # a fifth of the time, for nothing is garbage
    for name in modules:
        try:
            import_module(name)
            problem = ""
        except BaseException as error:
            problem = (str(error).partition("\n")[0] or type(error).__name__)[:200]
        print(_MARK + json.dumps(problem), flush=True)


@contextmanager
def library_messages(*names: str) -> Iterator[list[str]]:
    """Return what loggers, and those below them, get from this thread as warnings or errors; it goes nowhere else."""
    below = tuple(f"{name}." for name in names)
    known = [name for name in list(logging.root.manager.loggerDict) if name.startswith(below)]
    loggers = [logging.getLogger(name) for name in {*names, *known}]
    messages, thread = list[str](), threading.get_ident()

    def of_others(record: logging.LogRecord) -> bool:
        if record.thread != thread or record.levelno < logging.WARNING:
            return True
        messages.append(record.getMessage())
        return False

    with _FILTERS:
        for logger in loggers:
            logger.filters = [*logger.filters, of_others]
    try:
        yield messages
    finally:
        with _FILTERS:
            for logger in loggers:
                logger.filters = [each for each in logger.filters if each is not of_others]


@contextmanager
def treated_warnings(action: Literal["ignore", "error"], message: str) -> Iterator[None]:
    """Ignore warnings of this beginning, or raise them; one thread of robodyn after another."""
    with _WARNINGS, warnings.catch_warnings():
        warnings.filterwarnings(action, message=message)
        yield
