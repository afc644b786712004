"""What processes of tests are given to do; here, where processes that are started anew find it."""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from threading import Thread

import robodyn
from robodyn.errors import InputError


def figure_of(text: str) -> int:
    """The figure that a text is."""
    if not text.isdecimal():
        raise InputError(f"no figure: {text!r}")
    return int(text)


def leave(status: int) -> int:
    """The status, with which the process ends unless it is 0."""
    if status:
        os._exit(status)
    return status


def leave_at_once() -> None:
    """End the process."""
    os._exit(7)


def write_interrupted() -> str:
    """Write tables by polars for a while, and interrupt that."""
    import polars as pl

    frame = pl.DataFrame({name: [0.1] * 100_000 for name in "abcdefgh"})
    interrupting = Thread(target=_interrupt, daemon=True)
    interrupting.start()
    while interrupting.is_alive():
        frame.write_csv(os.devnull)
    return "written"


def _interrupt() -> None:
    for _ in range(20):
        time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)


def path_and_flags() -> None:
    """Print what Python is like here."""
    found = {"path": sys.path, "isolated": bool(sys.flags.isolated), "robodyn": robodyn.__file__}
    print(json.dumps({**found, "hooked": getattr(sys, "hooked", False)}))
