"""Ctrl-C ends the process with status 130, without a traceback, whatever is being imported or called back just then."""

from __future__ import annotations

import _thread
import signal
import sys
import time
from types import FrameType
from typing import Any, NoReturn

STATUS = 130
_seen: list[int] = []


def listen() -> None:
    """Note interrupts, unless the process has been told to ignore them."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)
        sys.unraisablehook = _again


def interrupted() -> bool:
    """Return whether there was an interrupt: an import that it broke off may end with another error."""
    return bool(_seen)


def _interrupt(number: int, _: FrameType | None) -> NoReturn:
    _seen.append(number)
    raise KeyboardInterrupt


def _soon() -> None:
    """Interrupt when the callback, and what tells of it, are left."""
    time.sleep(0.01)
    _thread.interrupt_main()


def _again(raised: Any) -> None:
    """Interrupt anew where a callback has swallowed it."""
    if isinstance(raised.exc_value, KeyboardInterrupt):
        _thread.start_new_thread(_soon, ())
    else:
        sys.__unraisablehook__(raised)
