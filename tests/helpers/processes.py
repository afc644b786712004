"""Python code run in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys


def environment(**changes: object) -> dict[str, str]:
    """This process's variables with some changed, or left out where they are None."""
    variables = {**os.environ, **changes}
    return {name: str(value) for name, value in variables.items() if value is not None}


def python(code: str, stdin: str = "", **changes: object) -> subprocess.CompletedProcess[str]:
    """Runs `code`, which may read `stdin`, with changes of the environment; it must end well."""
    done = subprocess.run(
        [sys.executable, "-I", "-c", code],
        input=stdin,
        capture_output=True,
        text=True,
        check=False,
        env=environment(**changes),
    )
    assert done.returncode == 0, done.stderr
    return done
