"""Which files are meant, and how many of them are worth processes of their own."""

from __future__ import annotations

import glob
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from typing import Any, TypeVar

from robodyn.errors import InputError
from robodyn.support.threads import cores, processes

R = TypeVar("R")
_LEAST_WORK = 500_000
"""Bytes of XML in files that take longer to check than processes take to start: half a second."""
_MESH = 5_000
"""Bytes of XML that take as long as a mesh of usual size, read anew."""


def files_of(sources: Sequence[str | os.PathLike[str] | bytes]) -> list[str | bytes]:
    """Return the files in the order given; a folder's and a pattern's in the order of their names; each once.

    Raises:
        InputError: a folder has no .urdf, or nothing matches a pattern.
    """
    found: dict[str | bytes, None] = {}
    for source in sources:
        if isinstance(source, bytes):
            found[source] = None
        else:
            found.update(dict.fromkeys(_expanded(os.fspath(source))))
    return list(found)


def _expanded(path: str) -> list[str]:
    if os.path.isdir(path):
        return _some(
            sorted(glob.iglob("**/*.urdf", root_dir=path, recursive=True)), path, "no .urdf in the folder", path
        )
    if os.path.exists(path) or not glob.has_magic(path):
        return [path]
    return _some(sorted(glob.iglob(path, recursive=True)), "", "nothing matches the pattern", path)


def _some(names: list[str], folder: str, what: str, path: str) -> list[str]:
    if not names:
        raise InputError(what, remedy="check the name", file=path)
    return [os.path.join(folder, name) for name in names]


def worth_processes(files: Sequence[str | bytes]) -> bool:
    """Return whether there is more work, in XML and in the meshes that it names, than starting processes is."""
    if len(files) < 2 or cores() < 2:
        return False
    return sum(map(_work, files)) > _LEAST_WORK


def _work(file: str | bytes) -> int:
    if isinstance(file, bytes) or not os.path.isfile(file):
        return 0
    with open(file, "rb") as stream:
        data = stream.read()
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
