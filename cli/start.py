"""The installed command `robodyn`: `main`, started and ended quickly."""

from __future__ import annotations

import atexit
import gc
import os
import sys
from typing import TYPE_CHECKING, NoReturn

if TYPE_CHECKING:
    from types import FrameType

_seen: list[int] = []
"""Interrupts: an import that one broke off may end with another error."""


def start() -> NoReturn:
    """Run the command line and end the process with its exit status. Searching for garbage in imports, and taking all
    apart at the end, would take a third of a small job; BLAS's threads would wait for each other."""
    gc.set_threshold(100_000, 20, 20)  # imports make about as many objects, none of them garbage
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ["PYTHONSAFEPATH"] = "1"  # for processes that libraries start
    # `python -m` and an empty entry of PYTHONPATH put the current folder there; robodyn itself is found already.
    here, library = os.path.realpath(os.curdir), os.path.dirname(os.__file__)
    before = sys.path.index(library) if library in sys.path else 0
    sys.path[:before] = [path for path in sys.path[:before] if os.path.realpath(path or os.curdir) != here]
    status = 0
    try:
        import signal

        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # else the process shall ignore it
            signal.signal(signal.SIGINT, _interrupt)
        from robodyn.cli.main import main

        main(lambda: bool(_seen))
    except SystemExit as end:
        if not isinstance(end.code, int):
            raise
        status = end.code
    except BaseException:
        if not _seen:
            raise
        status = 130
    _leave(status)


def _interrupt(number: int, _: FrameType | None) -> NoReturn:
    _seen.append(number)
    raise KeyboardInterrupt


def _leave(status: int) -> NoReturn:
    """End as Python does, but without taking apart what is in memory; threads are waited for."""
    threading = sys.modules.get("threading")
    if threading is not None and threading.active_count() > 1:
        sys.exit(status)
    atexit._run_exitfuncs()
    try:
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:
                stream.flush()
    except (OSError, ValueError):
        sys.exit(status)
    os._exit(status)
