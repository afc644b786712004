"""Python code run in a process of its own, and a command whose standard streams are on a terminal."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest


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


def on_terminal(call: list[str], stdout: bool, stderr: bool, columns: int = 300, **environment: str) -> tuple[str, str]:
    """What the terminal shows and what goes to pipes, of a command with these streams on a terminal."""
    pty = pytest.importorskip("pty")
    import fcntl
    import struct
    import termios

    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 40, columns, 0, 0))
    with subprocess.Popen(
        call,
        stdin=subprocess.DEVNULL,
        stdout=slave if stdout else subprocess.PIPE,
        stderr=slave if stderr else subprocess.PIPE,
        env={**os.environ, "TERM": "xterm-256color", **environment},
    ) as child:
        os.close(slave)
        shown = b""
        while True:
            try:
                data = os.read(master, 65536)
            except OSError:
                break
            if not data:
                break
            shown += data
        piped = b"".join(stream.read() for stream in (child.stdout, child.stderr) if stream)
    os.close(master)
    assert child.returncode == 0
    return shown.decode().replace("\r\n", "\n"), piped.decode()
