"""Checking the files of a project: each with the settings that hold for it, and xacro files expanded."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from robodyn.checks.config import Config, find_config, read_config
from robodyn.checks.fixes.fix import Fixed, fixed
from robodyn.checks.rule import Finding
from robodyn.checks.run import EVERYTHING, Checked, Options, Unread, check_one, read_one, rules_for
from robodyn.checks.sources import each_in_a_process, files_of, worth_processes
from robodyn.errors import InputError
from robodyn.robot.urdf.document import Reading
from robodyn.robot.urdf.packages import EXPANDED
from robodyn.robot.urdf.parts import Description
from robodyn.robot.urdf.sources import is_xacro, read_source

STDIN = "<stdin>"


@dataclass(frozen=True)
class Task:
    """A file, or the bytes of standard input, and how to check it."""

    source: str | bytes
    options: Options

    @property
    def name(self) -> str:
        """The file as findings show it."""
        if isinstance(self.source, bytes):
            return STDIN
        return self.source + EXPANDED if is_xacro(self.source) else self.source

    def reading(self) -> Reading:
        return read_one(self.source, self.options)


def tasks_for(
    sources: Sequence[str | bytes], given: Options = EVERYTHING, config: str | None = None
) -> tuple[Task, ...]:
    """Return the files of the sources, each with its options.

    Args:
        sources: files, folders, patterns, or the bytes of standard input, for which the settings of the current folder
            hold.
        given: the options of the call; they win over those of the project, or are added to them (see `Config.of`).
        config: a file whose settings hold for all; by default those found above each file.

    Raises:
        InputError: nothing matches a source, there is no such rule, or settings are wrong.
    """
    rules_for(given)
    fixed = None if config is None else read_config(config)
    known: dict[str, Config | None] = {}
    return tuple(Task(file, _options(file, given, fixed, known)) for file in files_of(sources))


def check_tasks(tasks: Sequence[Task], done: Callable[[], None] = lambda: None) -> Checked:
    """Return the findings in all of them; many files are shared out among processes, one for each core.

    One that cannot be read stops no other.

    Args:
        tasks: the files.
        done: called after each.
    """
    shared_out = worth_processes([task.source for task in tasks])
    each: Iterable[tuple[Finding, ...] | InputError] = (
        each_in_a_process(_check, [(task,) for task in tasks]) if shared_out else map(_check, tasks)
    )
    files, found, unread = list[str](), list[Finding](), list[Unread]()
    for task, outcome in zip(tasks, each, strict=True):
        if isinstance(outcome, InputError):
            unread.append(Unread(task.name, outcome))
        else:
            files.append(task.name)
            found += outcome
        done()
    return Checked(tuple(files), tuple(found), tuple(unread))


def check_description(description: Description, given: Options = EVERYTHING) -> Checked:
    """Return the findings in a description that was read, with the settings of its project."""
    options = _options(description.file.removesuffix(EXPANDED), given, None, {})
    return Checked((description.file,), check_one(description.data, options, description.file))


def fix_task(task: Task, unsafe: bool = False) -> Fixed:
    """Return the text of a file with its fixes made (see `fixed`), which is not written; of a xacro file as it is."""
    name = task.name
    _, data = read_source(task.source, name)
    if is_xacro(task.source):
        return Fixed(name, data, data)
    return fixed(data, name, lambda text: check_one(text, task.options, name), unsafe=unsafe)


def _check(task: Task) -> tuple[Finding, ...] | InputError:
    try:
        return check_one(task.source, task.options)
    except InputError as error:
        return error


def _options(file: str | bytes, given: Options, fixed: Config | None, known: dict[str, Config | None]) -> Options:
    path = STDIN if isinstance(file, bytes) else file
    config = fixed or find_config(os.path.dirname(path), known)
    return given if config is None else config.of(path, given)
