"""Ctrl-C ends the process with status 130, without a traceback, whatever is being imported just then."""

from __future__ import annotations

import signal
from types import FrameType
from typing import NoReturn

STATUS = 130
_seen: list[int] = []


def listen() -> None:
    """Note interrupts, unless the process has been told to ignore them."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)


def interrupted() -> bool:
    """Return whether there was an interrupt: an import that it broke off may end with another error."""
    return bool(_seen)


def _interrupt(number: int, _: FrameType | None) -> NoReturn:
    _seen.append(number)
    raise KeyboardInterrupt
