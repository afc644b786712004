"""Which trajectories a batch has, where their results go, and what is the same for all of them."""

from __future__ import annotations

import os
import threading
import zlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from glob import glob, has_magic
from hashlib import blake2b
from pathlib import Path
from typing import Any, NamedTuple

import robodyn
from robodyn.errors import InputError
from robodyn.robot.load import load
from robodyn.robot.model import Model
from robodyn.scene.parts import Payload
from robodyn.scene.read import parse_scenes
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.cache import code_digest
from robodyn.support.extras import need
from robodyn.support.input_file import open_input
from robodyn.support.libraries import version_of
from robodyn.trajectory.table import FILE_TYPES, READABLE, log_kind

REMEDY = "give --out another folder"
_SUFFIXES = {"csv": ".csv", "parquet": ".parquet", "npz": ".npz"}


class Job(NamedTuple):
    """One trajectory.

    Attributes:
        name: as it was given; path: absolute, as are
        table, document: where its torques and its report go; shown: the table's name as it is printed.
    """

    name: str
    path: str
    table: str
    document: str
    shown: str


def jobs_of(patterns: Sequence[str], out: str, beside: Sequence[str] = ()) -> list[Job]:
    """Return the jobs of names and patterns (`runs/*.csv`, `runs/**/*.csv`) in their order, each file once.

    Args:
        beside: other files that are read.

    Results keep the name and the type of their trajectory; those of several folders keep the folders that differ.

    Raises:
        InputError: a pattern fits no file, a type of file is not known, two results would have one name, or a result
            would overwrite its trajectory.
    """
    names = list(dict.fromkeys(name for pattern in patterns for name in _named(pattern)))
    paths = [os.path.abspath(name) for name in names]
    common = os.path.commonpath([os.path.dirname(path) for path in paths])
    jobs: dict[str, Job] = {}
    for name, path in zip(names, paths, strict=True):
        stem, suffix = os.path.splitext(os.path.relpath(path, common))
        kind = FILE_TYPES.get(suffix.lower(), "csv" if log_kind(path) else None)
        if kind is None:
            remedy = f"suffixes: {' '.join(READABLE)}"
            raise InputError("unknown type of table by this suffix", remedy=remedy, file=name)
        if kind == "parquet":
            need("Parquet tables", "pyarrow", file=name)
        shown = os.path.join(out, stem + _SUFFIXES[kind])
        table = os.path.abspath(shown)
        job = Job(name, path, table, os.path.splitext(table)[0] + ".json", shown)
        if job.document in jobs and jobs[job.document].path != path:
            what = f"the results of '{jobs[job.document].name}' would have the same name"
            raise InputError(what, remedy="rename one of them, or give each a --out of its own", file=name)
        jobs[job.document] = job
    _check_results([*jobs.values()], [*names, *beside])
    return list(jobs.values())


def _check_results(jobs: Sequence[Job], inputs: Sequence[str]) -> None:
    """Raise if a result would overwrite what is read, by whatever name."""
    read = {_identity(name): name for name in inputs}
    for job in jobs:
        over = read.get(_identity(job.table)) or read.get(_identity(job.document))
        if over is not None:
            raise InputError("the output would overwrite an input", remedy=REMEDY, file=over)


def _identity(path: str) -> tuple[int, int] | str:
    """Return what is the same for all names of a file."""
    with suppress(OSError, ValueError):
        status = os.stat(path)
        return status.st_dev, status.st_ino
    return os.path.realpath(path)


def _named(pattern: str) -> list[str]:
    """Return the files that a pattern stands for; a name stands for itself, whether it exists or not."""
    if not is_pattern(pattern):
        return [pattern]
    found = sorted(name for name in glob(pattern, recursive=True) if not os.path.isdir(name))
    if not found:
        raise InputError("no file fits this pattern", remedy="it is sought from the current folder", file=pattern)
    return found


def is_pattern(name: str) -> bool:
    """Return whether a name has wildcards, and is not that of a file."""
    return has_magic(name) and not os.path.lexists(name)


VERSION = f"{version_of('robodyn')}, code {code_digest(Path(robodyn.__file__).parent, without='cli')[:12]}"
"""Of robodyn as this process has loaded it; the command line, which computes nothing, does not count."""


BETWEEN = b"\0"
"""Between the bytes of scenes: no TOML has it."""


@dataclass(frozen=True)
class Setup:
    """Robot, scene and options.

    Attributes:
        robot, scene: the files' bytes, packed by zlib, of scenes with BETWEEN between them; None where there is none.
        gravity: m/s^2, in place of the scene's; payloads: beside the scene's; base_held: something carries the base.
        reading: as for `read_motion`; options: as for `torques`, with the threads of each process.
        version: of robodyn and its code, which all machines must have.
    """

    robot: bytes
    scene: bytes | None
    gravity: tuple[float, float, float] | None
    payloads: tuple[Payload, ...]
    base_held: bool
    reading: Mapping[str, Any]
    options: Mapping[str, Any]
    version: str = VERSION

    @property
    def _scenes(self) -> list[tuple[bytes, str]]:
        return [(data, "<scene>") for data in zlib.decompress(self.scene or b"").split(BETWEEN)]

    def loaded(self) -> tuple[Model, Scene]:
        """Return the robot and its scene, read once by each thread, which then has programs of its own."""
        if getattr(_KEPT, "setup", None) != self:
            scene = DEFAULT if self.scene is None else parse_scenes(self._scenes)
            scene = scene.changed(self.gravity, self.payloads, held=self.base_held)
            _KEPT.robot = load(zlib.decompress(self.robot), moving_base=scene.moving_base), scene
            _KEPT.setup = self
        robot: tuple[Model, Scene] = _KEPT.robot
        return robot

    def digest(self, path: str) -> str:
        """Return a hash of all that a trajectory's results depend on: its bytes, robot, scene, options, version.

        Raises:
            OSError: the file cannot be read.
        """
        scene = None if self.scene is None else zlib.decompress(self.scene)
        options = dict(sorted({**self.options, "threads": 1}.items()))  # they come in the order of the call
        same = replace(self, robot=zlib.decompress(self.robot), scene=scene, options=options)
        hashed = blake2b(repr(same).encode(), digest_size=20)
        with open_input(path) as stream:
            while piece := stream.read(1 << 20):
                hashed.update(piece)
        return hashed.hexdigest()


_KEPT = threading.local()
