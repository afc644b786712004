"""The examples of README.md: fenced blocks that are run, and what they print put in their places.

`console` blocks are commands after `$ ` with their output; `pycon` blocks are Python after `>>> `; in `sh` blocks there
are commands without their output. All of them run in one folder, in which robots/ is that of the repository.
"""

from __future__ import annotations

import contextlib
import doctest
import io
import math
import os
import re
import subprocess
import sys
from itertools import zip_longest
from pathlib import Path

ROOT = Path(__file__).parents[2]
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:e[-+]?\d+)?")
ELSEWHERE = ("pip install .", 'pip install ".[test]"', "pytest")
"""Commands that `.ci/run` runs instead."""


def blocks(text: str, language: str) -> list[str]:
    """The fenced blocks of a language."""
    return [found[2] for found in FENCE.finditer(text) if found[1] == language]


def commands(block: str) -> list[str]:
    """The commands of a console block, continued lines included."""
    return [found[1] for found in re.finditer(r"^\$ ((?:.*\\\n)*.*)$", block, re.MULTILINE)]


def regenerated(text: str, folder: Path) -> str:
    """The text with the output of every example as it is now."""
    (folder / "robots").symlink_to(ROOT / "robots", target_is_directory=True)
    shown = {"console": _console, "pycon": _session, "sh": _quiet}

    def block(found: re.Match[str]) -> str:
        return f"```{found[1]}\n{shown[found[1]](found[2], folder)}```" if found[1] in shown else found[0]

    return FENCE.sub(block, text)


def ran(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """A shell command where nothing is a terminal, its errors among what it prints."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return subprocess.run(
        ["sh", "-c", command],
        cwd=folder,
        env={**os.environ, "PATH": path, "COLUMNS": "80", "LC_ALL": "C.UTF-8"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        check=False,
    )


def _console(block: str, folder: Path) -> str:
    return "".join(f"$ {command}\n{ran(command, folder).stdout}" for command in commands(block))


def _quiet(block: str, folder: Path) -> str:
    """The block as it is; its commands but those of ELSEWHERE must succeed."""
    for line in block.splitlines():
        for command in (part.strip() for part in line.partition("#")[0].split("&&")):
            if command and command not in ELSEWHERE:
                done = ran(command, folder)
                assert done.returncode == 0, f"{command}: {done.stdout}"
    return block


def _session(block: str, folder: Path) -> str:
    names: dict[str, object] = {}
    examples = doctest.DocTestParser().get_examples(block)
    before = Path.cwd()
    os.chdir(folder)
    try:
        return "".join(_prompted(example.source) + _shown(example.source, names) for example in examples)
    finally:
        os.chdir(before)


def _prompted(source: str) -> str:
    first, *more = source.splitlines()
    return "".join([f">>> {first}\n", *(f"... {line}\n" for line in more)])


def _shown(source: str, names: dict[str, object]) -> str:
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(source, "<README.md>", "single"), names)
    return out.getvalue()


def same(found: str, expected: str) -> bool:
    """Whether two texts say the same, numbers to 1e-9; in lines with rounding errors (below 1e-12) only words count."""
    pairs = list(zip_longest(found.splitlines(), expected.splitlines(), fillvalue=""))
    return all(_same_line(ours, theirs) for ours, theirs in pairs)


def _same_line(ours: str, theirs: str) -> bool:
    numbers = [[float(x) for x in NUMBER.findall(line)] for line in (ours, theirs)]
    words = [" ".join(NUMBER.sub("#", line).split()) for line in (ours, theirs)]
    if words[0] != words[1]:
        return False
    noise = any(0 < abs(x) < 1e-12 for line in numbers for x in line)
    return noise or all(math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-12) for a, b in zip(*numbers, strict=True))
