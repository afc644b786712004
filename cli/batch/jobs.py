"""Which trajectories there are, and where their results go."""

from __future__ import annotations

import os
from collections.abc import Sequence
from glob import glob, has_magic
from typing import NamedTuple

from robodyn.errors import InputError
from robodyn.trajectory.open import FILE_TYPES

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


def jobs_of(patterns: Sequence[str], out: str) -> list[Job]:
    """The jobs that names and patterns (`runs/*.csv`, `runs/**/*.csv`) stand for, in their order, each file once.

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
        kind = FILE_TYPES.get(suffix.lower())
        if kind is None:
            raise InputError(
                "unknown type of table by this suffix", remedy=f"suffixes: {' '.join(FILE_TYPES)}", file=name
            )
        shown = os.path.join(out, stem + _SUFFIXES[kind])
        table = os.path.abspath(shown)
        job = Job(name, path, table, os.path.splitext(table)[0] + ".json", shown)
        if job.document in jobs and jobs[job.document].path != path:
            what = f"the results of '{jobs[job.document].name}' would have the same name"
            raise InputError(what, remedy="rename one of them, or give each a --out of its own", file=name)
        jobs[job.document] = job
    inputs = {os.path.realpath(path): name for name, path in zip(names, paths, strict=True)}
    for job in jobs.values():
        if (over := inputs.get(os.path.realpath(job.table))) is not None:
            raise InputError("the output would overwrite an input", remedy="give --out another folder", file=over)
    return list(jobs.values())


def _named(pattern: str) -> list[str]:
    """The files that a pattern stands for; a name stands for itself, whether it exists or not."""
    if not is_pattern(pattern):
        return [pattern]
    found = sorted(name for name in glob(pattern, recursive=True) if not os.path.isdir(name))
    if not found:
        raise InputError("no file fits this pattern", remedy="it is sought from the current folder", file=pattern)
    return found


def is_pattern(name: str) -> bool:
    """Whether a name has wildcards, and is not that of a file."""
    return has_magic(name) and not os.path.lexists(name)
