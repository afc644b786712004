"""The real command, run in this process or in one of its own, and a robot with a motion to run it on."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from contextlib import ExitStack, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import pytest

from robodyn.cli.main import main

ROBOTS = Path(__file__).parents[2] / "robots"

ARM = """<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0.1 0 0.02"/><mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit effort="50" velocity="5" lower="-3" upper="3"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.4 0 0"/>
    <axis xyz="0 1 0"/><limit effort="50" velocity="5" lower="-3" upper="3"/></joint>
</robot>
"""
HEADER = "time,q_shoulder,q_elbow,qd_shoulder,qd_elbow,qdd_shoulder,qdd_elbow\n"


def motion(rows: int) -> str:
    """A table in which the arm turns at a constant rate, at 100 Hz."""
    return HEADER + "".join(f"{i / 100},{0.1 * i / 100},{0.2 * i / 100},0.1,0.2,0,0\n" for i in range(rows))


def write_arm(folder: Path, rows: int = 10) -> None:
    """Write `arm.urdf` and `arm.csv`."""
    (folder / "arm.urdf").write_text(ARM)
    (folder / "arm.csv").write_text(motion(rows))


@dataclass(frozen=True)
class Outcome:
    status: int
    out: str
    err: str


def run(*args: str, stdin: bytes = b"", one_stream: bool = False) -> Outcome:
    """`robodyn args` in this process, with standard streams that are not terminals; `one_stream` is `2>&1`."""
    out, err = (io.TextIOWrapper(io.BytesIO(), encoding="utf-8") for _ in range(2))
    if one_stream:
        err = out
    source = io.TextIOWrapper(io.BytesIO(stdin))
    with ExitStack() as stack:
        for patch in (mock.patch("sys.argv", ["robodyn", *args]), mock.patch("sys.stdin", source)):
            stack.enter_context(patch)
        stack.enter_context(redirect_stdout(out))
        stack.enter_context(redirect_stderr(err))
        with pytest.raises(SystemExit) as end:
            main()
    assert isinstance(end.value.code, int)
    return Outcome(end.value.code, _text(out), _text(err))


def spawn(*args: str, stdin: bytes = b"", cwd: Path | None = None, **environment: str) -> Outcome:
    """`robodyn args` in a process of its own."""
    variables = {**os.environ, **environment}
    done = subprocess.run(command(*args), input=stdin, capture_output=True, cwd=cwd, env=variables, check=False)
    return Outcome(done.returncode, done.stdout.decode(), done.stderr.decode())


def shown(*args: str) -> str:
    """What `robodyn args` prints; it has to end well."""
    outcome = run(*args)
    assert (outcome.status, outcome.err) == (0, "")
    return outcome.out


def document(*args: str) -> Any:
    """What `robodyn args` prints as JSON."""
    return json.loads(shown(*args, "--format", "json"), parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))


def refused(outcome: Outcome, line: str) -> None:
    """The command has ended with one line of error that begins so, status 2, and nothing else."""
    assert (outcome.status, outcome.out) == (2, ""), outcome
    assert len(outcome.err.splitlines()) == 1, outcome.err
    assert outcome.err.startswith(f"error: {line}"), outcome.err


def command(*args: str) -> list[str]:
    """What to start for `robodyn args`."""
    return [sys.executable, "-c", "from robodyn.cli.main import main; main()", *args]


def _text(stream: io.TextIOWrapper) -> str:
    stream.flush()
    buffer = stream.buffer
    assert isinstance(buffer, io.BytesIO)
    return buffer.getvalue().decode()
