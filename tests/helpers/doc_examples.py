"""The examples of README.md and docs/: fenced blocks that are run, and what they print put in their places.

`console` blocks are commands after `$ `, continued after `> `, with their output; `pycon` blocks are Python after
`>>> `; in `sh` blocks there are commands without their output. The blocks of a page share one folder, in which robots/
and tests/ are those of the repository, and the names that they define in Python.
"""

from __future__ import annotations

import contextlib
import doctest
import io
import math
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from itertools import zip_longest
from pathlib import Path
from unittest import mock

from helpers.command_line import run

ROOT = Path(__file__).parents[2]
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:e[-+]?\d+)?")
GENERATED = ("reference/commands.md", "reference/python.md", "reference/json_keys.md", "reference/rules/")
"""Pages in docs/ that are written when Sphinx starts; see `docs/generated_pages.py`."""
PLAIN = re.compile(r"robodyn ([^|;&<>$*?`\n]*)(?:\| (.*))?")
"""A call of robodyn, and the filters that read what it prints."""
ELSEWHERE = re.compile(
    r"pip install|pytest|python -m (?:pytest|benchmarks)|sphinx-build|ruff |mypy |git |cd |\.ci/run|pre-commit"
)
"""How commands begin that install, test, measure or build; `.ci/run` does that instead, and slow tests do."""


def hand_written() -> list[Path]:
    """Return every page that is kept in the repository: README.md, those beside it and those in docs/."""
    docs = ROOT / "docs"
    pages = [page for page in docs.rglob("*.md") if not page.relative_to(docs).as_posix().startswith(GENERATED)]
    return [*sorted(ROOT.glob("*.md")), *sorted(pages)]


def blocks(text: str, language: str) -> list[str]:
    """Return the fenced blocks of a language."""
    return [found[2] for found in FENCE.finditer(text) if found[1] == language]


def commands(block: str) -> list[str]:
    """Return the commands of a console block, continued lines included."""
    return [found[1] for found in re.finditer(r"^\$ ((?:.*(?:\\\n|\n(?=> )))*.*)$", block, re.MULTILINE)]


def regenerated(text: str, folder: Path) -> str:
    """Return the text with the output of every example as it is now."""
    for shared in ("robots", "tests"):
        (folder / shared).symlink_to(ROOT / shared, target_is_directory=True)
    names: dict[str, object] = {}
    shown = {"console": _console, "pycon": partial(_session, names), "sh": _quiet}

    def block(found: re.Match[str]) -> str:
        return f"```{found[1]}\n{shown[found[1]](found[2], folder)}```" if found[1] in shown else found[0]

    return FENCE.sub(block, text)


def ran(command: str, folder: Path) -> str:
    """Return what a shell command prints where nothing is a terminal, its errors among it.

    What begins with `robodyn` and has nothing more for the shell than filters behind it runs in this process, which
    saves Python's start.
    """
    command = command.replace("\n> ", "\n").replace("\\\n", "")
    if plain := PLAIN.fullmatch(command):
        with working_in(folder), mock.patch.dict(os.environ, COLUMNS="80"):
            done = run(*shlex.split(plain[1]), one_stream=not plain[2])
        return done.err + _shell(plain[2], folder, done.out) if plain[2] else done.out
    return _shell(command, folder)


def _shell(command: str, folder: Path, stdin: str = "") -> str:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return subprocess.run(
        ["sh", "-c", command],
        cwd=folder,
        env={**os.environ, "PATH": path, "COLUMNS": "80", "LC_ALL": "C.UTF-8"},
        input=stdin,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        check=False,
    ).stdout


def _console(block: str, folder: Path) -> str:
    return "".join(f"$ {command}\n{ran(command, folder)}" for command in commands(block))


def _quiet(block: str, folder: Path) -> str:
    """Return the block as it is; its commands but those of ELSEWHERE must succeed.

    They run in this process, where a test may have made measurements short.
    """
    with working_in(folder):
        for line in block.splitlines():
            for command in (part.strip() for part in line.partition("#")[0].split("&&")):
                if command and not ELSEWHERE.match(command):
                    program, *arguments = shlex.split(command)
                    assert program == "robodyn", f"{command}: only robodyn is run in blocks without output"
                    done = run(*arguments)
                    assert done.status == 0, f"{command}: {done.err}"
    return block


@contextlib.contextmanager
def working_in(folder: Path) -> Iterator[None]:
    """Have the folder for the current one."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def _session(names: dict[str, object], block: str, folder: Path) -> str:
    examples = doctest.DocTestParser().get_examples(block)
    known = {*sys.modules}
    sys.path.insert(0, str(folder))  # as at a prompt: modules that commands have written can be imported
    try:
        with working_in(folder):
            return "".join(_prompted(example.source) + _shown(example.source, names) for example in examples)
    finally:
        sys.path.remove(str(folder))
        for name in {*sys.modules} - known:
            if str(getattr(sys.modules[name], "__file__", "")).startswith(f"{folder}{os.sep}"):
                del sys.modules[name]


def _prompted(source: str) -> str:
    first, *more = source.splitlines()
    return "".join([f">>> {first}\n", *(f"... {line}\n" for line in more)])


def _shown(source: str, names: dict[str, object]) -> str:
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(source, "<page>", "single"), names)
    return out.getvalue()


def same(found: str, expected: str) -> bool:
    """Tell whether two texts agree, numbers to 1e-9; in lines with rounding errors (below 1e-12) only words count."""
    pairs = list(zip_longest(found.splitlines(), expected.splitlines(), fillvalue=""))
    return all(_same_line(ours, theirs) for ours, theirs in pairs)


def _same_line(ours: str, theirs: str) -> bool:
    numbers = [[float(x) for x in NUMBER.findall(line)] for line in (ours, theirs)]
    words = [" ".join(NUMBER.sub("#", line).split()) for line in (ours, theirs)]
    if words[0] != words[1]:
        return False
    noise = any(0 < abs(x) < 1e-12 for line in numbers for x in line)
    return noise or all(math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-12) for a, b in zip(*numbers, strict=True))
