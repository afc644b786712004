"""A function that does not survive in a process beside the one that it belongs to."""

from __future__ import annotations

import os


def at_home(home: int, value: int) -> int:
    """The value in the process `home`; any other ends."""
    if os.getpid() != home:
        os._exit(3)
    return value
