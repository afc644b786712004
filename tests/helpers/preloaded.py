"""Run tests in forks of one Python that has the packages of others imported: each of them starts at once.

`python -m helpers.preloaded` reads requests, one in a line, and answers each with the exit status of its tests;
with a request as its arguments, it is the process that runs those tests.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

FORKS = sys.platform == "linux"
"""Elsewhere libraries of the system need not survive a fork; each run starts a Python of its own there."""

_TESTS = Path(__file__).parents[1]
_COMMAND = [sys.executable, "-m", "helpers.preloaded"]
_OUTPUT = "output.txt"
"""In the folder of a run: what it wrote."""

_MODULES = (
    "hypothesis.strategies",
    "hypothesis.internal.conjecture.engine",
    "numpy.testing",
    "scipy.integrate",
    "scipy.optimize",
    "scipy.spatial",
    "llvmlite.binding",
    "mpmath",
    "xdist.plugin",
    "anyio.pytest_plugin",
)


class Preloaded:
    """Tests against the package in a folder, in a process of their own.

    Args:
        environment: of the tests, beside this process's own.
    """

    def __init__(self, environment: dict[str, str]) -> None:
        self._environment = os.environ | environment
        self._server: subprocess.Popen[str] | None = None

    def run(self, folder: Path, arguments: list[str]) -> tuple[int, str]:
        """Return the exit status and the output of pytest with these arguments."""
        if not FORKS:
            return self._apart(folder, arguments)
        server = self._server = self._server or self._served()
        print(json.dumps([str(folder), *arguments]), file=server.stdin, flush=True)
        status = server.stdout.readline()
        return int(status), (folder / _OUTPUT).read_text()

    def end(self) -> None:
        """End what serves the runs; the next run starts it anew."""
        if self._server:
            self._server.communicate()
            self._server = None

    def _served(self) -> subprocess.Popen[str]:
        pipe = subprocess.PIPE
        return subprocess.Popen(_COMMAND, cwd=_TESTS, env=self._environment, stdin=pipe, stdout=pipe, text=True)

    def _apart(self, folder: Path, arguments: list[str]) -> tuple[int, str]:
        command = [*_COMMAND, str(folder), *arguments]
        done = subprocess.run(command, check=False, cwd=_TESTS, env=self._environment, capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr


@contextlib.contextmanager
def preloaded(**environment: str) -> Iterator[Preloaded]:
    """Yield what runs tests, in processes with these environment variables too, and end it."""
    runs = Preloaded(environment)
    try:
        yield runs
    finally:
        runs.end()


def _tested(folder: str, *arguments: str) -> None:
    """Run pytest in a folder against the package there, write first where it was found, and end the process."""
    sys.path.insert(0, folder)
    os.environ["PYTHONPATH"] = folder
    os.chdir(folder)
    import robodyn

    print(robodyn.__file__)
    status = int(pytest.main(list(arguments)))
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


def _serve() -> None:
    for name in _MODULES:
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    assert not any(name.split(".")[0] == "robodyn" for name in sys.modules)
    gc.collect()
    gc.freeze()
    for line in sys.stdin:
        if (child := os.fork()) == 0:
            _forked(*json.loads(line))
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)


def _forked(folder: str, *arguments: str) -> None:
    try:
        with open(os.path.join(folder, _OUTPUT), "w") as output, open(os.devnull) as nothing:
            os.dup2(nothing.fileno(), 0)
            os.dup2(output.fileno(), 1)
            os.dup2(output.fileno(), 2)
        _tested(folder, *arguments)
    finally:
        os._exit(-1)


if __name__ == "__main__":
    if sys.argv[1:]:
        _tested(*sys.argv[1:])
    _serve()
