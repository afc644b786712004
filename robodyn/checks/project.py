"""The files of a project, each with the settings that hold for it."""

from __future__ import annotations

import os
from collections.abc import Sequence

from robodyn.checks.config import Config, find_config, read_config
from robodyn.checks.fixes.fix import Fixed, fixed
from robodyn.checks.run import EVERYTHING, STDIN, Checked, Options, Task, check_one, rules_for
from robodyn.checks.sources import files_of
from robodyn.robot.urdf.packages import EXPANDED
from robodyn.robot.urdf.parts import Description
from robodyn.robot.urdf.sources import is_xacro, read_source


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


def _options(file: str | bytes, given: Options, fixed: Config | None, known: dict[str, Config | None]) -> Options:
    path = STDIN if isinstance(file, bytes) else file
    config = fixed or find_config(os.path.dirname(path), known)
    return given if config is None else config.of(path, given)
