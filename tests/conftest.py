"""What all tests share: a cache of their own, children that can be interrupted, short measurements, less tidying."""

import gc
import os
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from typing import Any

import hypothesis
import pytest

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command does, before NumPy is imported
_QUICK = hypothesis.settings(  # without a deadline: how long an example takes says how busy the machine is
    deadline=None, max_examples=15, suppress_health_check=[hypothesis.HealthCheck.function_scoped_fixture]
)
hypothesis.settings.register_profile("quick", _QUICK)
hypothesis.settings.register_profile("thorough", _QUICK, max_examples=300)  # pytest --hypothesis-profile thorough
hypothesis.settings.load_profile("quick")
YOUNG = 200_000
"""Objects that are made before those among them that nothing uses are looked for; Python's own is 700."""


def pytest_configure(config: pytest.Config) -> None:
    folder = tempfile.TemporaryDirectory(prefix="robodyn-cache-")
    config.add_cleanup(folder.cleanup)
    os.environ["ROBODYN_CACHE"] = folder.name
    _let_children_hear()
    gc.disable()


def pytest_collection_finish() -> None:
    """Look no more at what is there for good: a third of the time of collecting 15 000 tests went into that."""
    gc.freeze()
    gc.set_threshold(YOUNG, 20, 20)
    gc.enable()


def pytest_sessionfinish() -> None:
    """Have pytest's last collections pass over what is left: each would look at millions of objects."""
    gc.freeze()


@pytest.fixture(autouse=True, scope="session")
def _measure_briefly() -> Iterator[None]:
    from helpers.hurried import hurry

    with pytest.MonkeyPatch.context() as monkeypatch:
        hurry(monkeypatch)
        yield


def _let_children_hear() -> None:
    """Give children the default handling of signals that a shell has this process ignore: after nohup, or behind &.

    What a process ignores its children ignore too; what it handles, if only by doing nothing, has its default there.
    """
    for name in ("SIGINT", "SIGHUP"):
        if (number := getattr(signal, name, None)) and signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, lambda *_: None)


@pytest.fixture
def children(monkeypatch: pytest.MonkeyPatch) -> list[subprocess.Popen[bytes]]:
    """The processes of Python that are started during the test, in their order."""
    from robodyn.support import processes

    started: list[subprocess.Popen[bytes]] = []
    start = processes.start_python

    def noted(*arguments: Any, **options: Any) -> subprocess.Popen[bytes]:
        started.append(start(*arguments, **options))
        return started[-1]

    monkeypatch.setattr(processes, "start_python", noted)
    return started
