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
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

FORKS = sys.platform == "linux"
"""Elsewhere libraries of the system need not survive a fork; each run starts a Python of its own there."""
Run = Callable[[Path, list[str]], tuple[int, str]]
"""Returns the exit status and the output of pytest with these arguments, against the package in a folder."""

_TESTS = Path(__file__).parents[1]
_COMMAND = [sys.executable, "-m", "helpers.preloaded"]
_OUTPUT = "output.txt"
"""In the folder of a run: what it wrote."""
_MODULES = (
    *("hypothesis.strategies", "hypothesis.internal.conjecture.engine", "numpy.testing", "scipy.integrate"),
    *("scipy.optimize", "scipy.spatial", "llvmlite.binding", "mpmath", "xdist.plugin", "anyio.pytest_plugin"),
)


@contextlib.contextmanager
def preloaded(**environment: str) -> Iterator[Run]:
    """Yield what runs tests, in processes with these environment variables too, and end it."""
    variables = os.environ | environment
    if not FORKS:

        def apart(folder: Path, arguments: list[str]) -> tuple[int, str]:
            call = [*_COMMAND, str(folder), *arguments]
            done = subprocess.run(call, check=False, cwd=_TESTS, env=variables, capture_output=True, text=True)
            return done.returncode, done.stdout + done.stderr

        yield apart
        return
    pipe = subprocess.PIPE
    with subprocess.Popen(_COMMAND, cwd=_TESTS, env=variables, stdin=pipe, stdout=pipe, text=True) as server:
        assert server.stdin
        assert server.stdout
        requests, answers = server.stdin, server.stdout

        def forked(folder: Path, arguments: list[str]) -> tuple[int, str]:
            print(json.dumps([str(folder), *arguments]), file=requests, flush=True)
            status = answers.readline()
            return int(status), (folder / _OUTPUT).read_text()

        yield forked
        requests.close()


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
