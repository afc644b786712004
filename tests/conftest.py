"""Compiled code of the tests is kept apart from the user's, and what tests start can be interrupted."""

import os
import signal
import tempfile

import pytest


def pytest_configure(config: pytest.Config) -> None:
    folder = tempfile.TemporaryDirectory(prefix="robodyn-cache-")
    config.add_cleanup(folder.cleanup)
    os.environ["ROBODYN_CACHE"] = folder.name
    _let_children_hear()


def _let_children_hear() -> None:
    """Give children the default handling of signals that a shell has this process ignore: after nohup, or behind &.

    What a process ignores its children ignore too; what it handles, if only by doing nothing, has its default there.
    """
    for name in ("SIGINT", "SIGHUP"):
        if (number := getattr(signal, name, None)) and signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, lambda *_: None)
