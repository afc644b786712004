"""The files of a project, each checked with the settings that hold for it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace

from robodyn.checks.config import Config, find_config, read_config
from robodyn.checks.fixes import Fixed, fixed
from robodyn.checks.groups import places
from robodyn.checks.rule import Finding
from robodyn.checks.run import STANDARD, STDIN, Checked, Options, Source, Task, check_tasks, found_in
from robodyn.checks.selection import rules_for
from robodyn.checks.sources import files_of
from robodyn.robot.urdf.packages import EXPANDED
from robodyn.robot.urdf.parts import Description
from robodyn.robot.urdf.sources import is_xacro, read_source


def check(
    sources: Source | Sequence[Source],
    options: Options = STANDARD,
    *,
    select: Sequence[str] = (),
    ignore: Sequence[str] = (),
    package_paths: Sequence[str | os.PathLike[str]] = (),
    xacro_args: Mapping[str, str] | None = None,
    trust_xacro: bool = False,
    config: str | os.PathLike[str] | None = None,
) -> tuple[Finding, ...]:
    """Return the findings in one or several descriptions, in the order of the files and of their text: one for each
    cause in a file, with its `places`.

        for finding in robodyn.check("robot.urdf", ignore=["RD110"]):
            print(finding.line, finding.code, finding.message)

    They are those of the command `robodyn check`: the settings of a project hold for its files, and xacro files are
    expanded first.

    Args:
        sources: paths of URDF or xacro files, folders (every .urdf below them) or patterns (`robots/*.urdf`), or bytes,
            for which the settings of the current folder hold.
        options: which rules run, and against what; the arguments below are added to them.
        select, ignore: codes of rules (RD207) or their beginnings (RD2), to run and not to run. Without `select` it is
            DEFAULT: errors, and what is likely a defect; ALL is everything.
        package_paths: packages, or folders of packages, that are looked at first for meshes and what xacro includes.
        xacro_args: values of the arguments of xacro files; defaults hold for the others.
        trust_xacro: let xacro files that are named run any Python, read any file and all of the environment; not those
            of folders and patterns.
        config: a file whose settings hold for all, in place of robodyn.toml or pyproject.toml above each.

    Raises:
        InputError: a file cannot be read, nothing matches a pattern, there is no such rule, or settings are wrong.
    """
    given = replace(
        options,
        select=(*options.select, *map(str.upper, select)),
        ignore=(*options.ignore, *map(str.upper, ignore)),
        package_path=(*options.package_path, *(os.fspath(path) for path in package_paths)),
        xacro_args=(*options.xacro_args, *(xacro_args or {}).items()),
        trust_xacro=options.trust_xacro or trust_xacro,
    )
    files = [sources] if isinstance(sources, (str, bytes, os.PathLike)) else sources
    checked = check_tasks(tasks_for(files, given, None if config is None else os.fspath(config)))
    if checked.unread:
        raise checked.unread[0].error
    return checked.findings


def tasks_for(sources: Sequence[Source], given: Options = STANDARD, config: str | None = None) -> tuple[Task, ...]:
    """Return the files of the sources, each with its options.

    Args:
        sources: files, folders, patterns, or the bytes of standard input, for which the settings of the current folder
            hold.
        given: the options of the call; they win over those of the project, or are added to them (see `Config.of`).
        config: a file whose settings hold for all; by default those found above each file.

    Raises:
        InputError: nothing matches a source, there is no such rule, or settings are wrong.
    """
    rules_for(given.select, given.ignore)
    fixed = None if config is None else read_config(config)
    known: dict[str, Config | None] = {}
    named = {os.fspath(source) for source in sources}
    others = replace(given, trust_xacro=False)
    return tuple(
        Task(file, _options(file, given if file in named else others, fixed, known)) for file in files_of(sources)
    )


def check_description(description: Description, given: Options = STANDARD) -> Checked:
    """Return the findings in a description that was read, with the settings of its project."""
    options = _options(description.file.removesuffix(EXPANDED), given, None, {})
    found = found_in(description.data, options, description.file)
    return Checked((description.file,), found.shown, hidden=found.hidden)


def fix_task(task: Task, unsafe: bool = False) -> Fixed:
    """Return the text of a file with its fixes made (see `fixed`), which is not written; of a xacro file as it is."""
    name = task.name
    _, data = read_source(task.source, name)
    if is_xacro(task.source):
        return Fixed(name, data, data)
    return fixed(data, name, lambda text: places(found_in(text, task.options, name).shown), unsafe=unsafe)


def _options(file: str | bytes, given: Options, fixed: Config | None, known: dict[str, Config | None]) -> Options:
    path = STDIN if isinstance(file, bytes) else file
    config = fixed or find_config(os.path.dirname(path), known)
    return given if config is None else config.of(path, given)
