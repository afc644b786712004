"""How many threads and processes work at a time."""

from __future__ import annotations

import os
import sys

from robodyn.errors import InputError

MOST_OF_WINDOWS = 61
"""Processes that one process can wait for under Windows."""


def cores(asked: int | None = None) -> int:
    """Return the number of threads asked for; None is as many as the process may use cores.

    Raises:
        InputError: less than 1.
    """
    if asked is not None:
        if asked < 1:
            raise InputError(f"{asked} threads cannot work", remedy="1 or more")
        return asked
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


def processes(jobs: int, asked: int | None = None, platform: str = sys.platform) -> int:
    """Return how many processes do some jobs: those asked for, or one for each core, as far as the system can."""
    most = MOST_OF_WINDOWS if platform == "win32" else jobs
    return min(asked or cores(), jobs, most)
