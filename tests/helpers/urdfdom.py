"""urdfdom's check_urdf, where it is installed: the descriptions that it refuses."""

from __future__ import annotations

import importlib.metadata
import os
import subprocess
from functools import cache
from pathlib import Path

PATIENCE = 10.0
"""Seconds that it may take for a file."""


@cache
def check_urdf() -> tuple[str, str] | None:
    """The program and the folder of its libraries; None where it is not installed."""
    try:
        files = importlib.metadata.files("cmeel-urdfdom") or []
    except importlib.metadata.PackageNotFoundError:
        return None
    (program,) = (
        Path(str(file.locate())).resolve()
        for file in files
        if file.name == "check_urdf" and "cmeel.prefix" in str(file)
    )
    return str(program), str(program.parents[1] / "lib")


def refused(file: Path) -> bool:
    """Return whether it refuses a file, or comes to no end with it, as with some cycles."""
    program = check_urdf()
    assert program is not None
    environment = {**os.environ, "LD_LIBRARY_PATH": program[1]}
    command, quiet = [program[0], str(file)], subprocess.DEVNULL
    try:
        done = subprocess.run(command, env=environment, stdout=quiet, stderr=quiet, timeout=PATIENCE, check=False)
    except subprocess.TimeoutExpired:
        return True
    return done.returncode != 0
