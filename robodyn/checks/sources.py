"""Which files are meant, and how many of them are worth processes of their own."""

from __future__ import annotations

import glob
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from typing import Any, TypeVar
from warnings import warn

from robodyn.checks.beside import BESIDE, describing
from robodyn.errors import InputError, NoRobotError, RobodynWarning
from robodyn.robot.urdf.sources import is_xacro
from robodyn.robot.urdf.xacro import only_defines
from robodyn.support.input_file import read_input
from robodyn.support.threads import cores, processes

R = TypeVar("R")
_LEAST_WORK = 500_000
"""Bytes of XML in files that take longer to check than processes take to start: half a second."""
_MESH = 5_000
"""Bytes of XML that take as long as a mesh of usual size, read anew."""


def files_of(sources: Sequence[str | os.PathLike[str] | bytes]) -> list[str | bytes]:
    """Return the files in the order given; a folder's and a pattern's in the order of their names; each once.

    Of a folder all .urdf below it; where there is none, all .xacro; of a mesh, an SRDF or a xacro file of macros the
    descriptions that name it (see `describing`), with a warning where there is none. Where others are named as well, so
    is a folder or a pattern without a description.

    Raises:
        InputError: there is no description in a folder, or nothing matches a pattern.
    """
    found: dict[str | bytes, None] = {}
    errors: list[InputError] = []
    for source in sources:
        try:
            found.update(dict.fromkeys([source] if isinstance(source, bytes) else _expanded(os.fspath(source))))
        except InputError as error:
            errors.append(error)
    fatal = [error for error in errors if not isinstance(error, NoRobotError)]
    if fatal and not found:
        raise fatal[0]
    for without in errors:
        warn(f"{without}: skipped", RobodynWarning, stacklevel=2)
    return list(found)


def _expanded(path: str) -> list[str]:
    if os.path.isdir(path):
        names = _below(path, ".urdf") or _below(path, ".xacro")
        if not names:
            raise InputError("no .urdf and no .xacro in the folder", remedy="check the name", file=path)
        return [os.path.join(path, name) for name in names]
    if os.path.exists(path) or not glob.has_magic(path):
        return describing(path) if os.path.isfile(path) and _belongs(path) else [path]
    names = sorted(glob.iglob(path, recursive=True))
    if not names:
        raise InputError("nothing matches the pattern", remedy="check the name", file=path)
    return names


def _belongs(path: str) -> bool:
    """Return whether a file is no description, but may belong to some."""
    return path.lower().endswith(BESIDE) or (is_xacro(path) and only_defines(path))


def _below(folder: str, suffix: str) -> list[str]:
    """Return the files below a folder, by their names in it, but those that begin with a dot; links to folders, which
    may lead anywhere and around, are not followed."""
    found = []
    for path, inner, files in os.walk(folder):
        inner[:] = [name for name in inner if name[0] != "."]
        found += [os.path.join(path, name) for name in files if name.endswith(suffix) and name[0] != "."]
    return sorted(os.path.relpath(name, folder) for name in found)


def worth_processes(files: Sequence[str | bytes]) -> bool:
    """Return whether there is more work, in XML and in the meshes that it names, than starting processes is."""
    if len(files) < 2 or cores() < 2:
        return False
    return sum(map(_work, files)) > _LEAST_WORK


def _work(file: str | bytes) -> int:
    if isinstance(file, bytes):
        return 0
    try:
        data = read_input(file)
    except (OSError, ValueError, InputError):  # told when it is checked
        return 0
    return len(data) + _MESH * data.count(b"<mesh")


def each_in_a_process(work: Callable[..., R], calls: Sequence[tuple[Any, ...]]) -> Iterator[R | InputError]:
    """Yield `work(*call)` of every call, in their order, on all cores; an error of a call that processes died of."""
    from robodyn.support.processes import Death, in_processes

    found: dict[int, R | InputError] = {}
    with closing(in_processes(work, calls, processes(len(calls)))) as done:
        for number in range(len(calls)):
            while number not in found:
                other, outcome = next(done)
                found[other] = InputError(str(outcome)) if isinstance(outcome, Death) else outcome
            yield found.pop(number)
