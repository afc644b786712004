"""Settings of a project: `[tool.robodyn.check]` of robodyn.toml or pyproject.toml, the nearest above a description."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Any

from robodyn.checks.catalogue import rules_for
from robodyn.checks.context import Options, Thresholds
from robodyn.errors import InputError, unreadable
from robodyn.robot.urdf.sources import is_xacro
from robodyn.scene.scene import Rule
from robodyn.scene.toml_table import TomlTable, read_toml
from robodyn.support.input_file import read_input
from robodyn.support.wording import shown

NAMES = ("robodyn.toml", "pyproject.toml")
"""What is looked for in each folder, in this order."""


@dataclass(frozen=True)
class Config:
    """What a project has set: the folder of its file, to which patterns and package paths are relative; options; and by
    patterns of files the codes that are ignored in those."""

    folder: str
    options: Options
    per_file: tuple[tuple[str, tuple[str, ...]], ...] = ()

    def of(self, path: str, given: Options) -> Options:
        """Return the options for one file, `given` being those of the call: its `select` and package path win over the
        project's, its `ignore` is added to it."""
        own, relative = self.options, os.path.relpath(path, self.folder).replace(os.sep, "/")
        names = (relative, f"./{relative}", os.path.basename(path))
        hit = [codes for pattern, codes in self.per_file if any(fnmatchcase(name, pattern) for name in names)]
        return replace(
            own,
            select=given.select or own.select,
            ignore=(*own.ignore, *(code for codes in hit for code in codes), *given.ignore),
            package_path=(*given.package_path, *(self._of_xacro() if is_xacro(path) else own.package_path)),
            xacro_args=given.xacro_args,
            trust_xacro=given.trust_xacro,
            asked=given.asked,
        )

    def _of_xacro(self) -> Iterator[str]:
        """Yield the package paths from which a xacro file may read: below the folder of the settings, which may come
        from anywhere themselves, all; elsewhere packages with a package.xml."""
        root = Path(os.path.realpath(self.folder))
        for path in map(Path, self.options.package_path):
            if Path(os.path.realpath(path)).is_relative_to(root) or (path / "package.xml").is_file():
                yield str(path)
            else:
                yield from sorted(str(manifest.parent) for manifest in path.glob("*/package.xml"))


def find_config(folder: str, known: dict[str, Config | None]) -> Config | None:
    """Return the settings that hold in a folder: of the nearest file, there or above, that has any; what is `known` of
    other folders is added to."""
    folder = os.path.abspath(folder)
    if folder not in known:
        above = os.path.dirname(folder)
        found = None
        for name in NAMES:
            with suppress(OSError):
                data = read_input(path := os.path.join(folder, name))
                found = found or (parse_config(data, path) if name == NAMES[0] or b"robodyn" in data else None)
        known[folder] = found or (find_config(above, known) if above != folder else None)
    return known[folder]


def read_config(path: str) -> Config:
    """Return the settings in a file; InputError where it cannot be read, is not TOML, has no such table, or a key in it
    is not understood."""
    try:
        config = parse_config(read_input(path), path)
    except (OSError, ValueError) as error:
        raise unreadable(error, path) from None
    if config is None:
        raise InputError("there is no table [tool.robodyn.check]", remedy="write one, or name another file", file=path)
    return config


def parse_config(data: bytes, file: str) -> Config | None:
    """Return the settings in TOML text; None where it has no table of ours. Errors are those of `read_config`."""
    values: Any = read_toml(data, file)
    if os.path.basename(file) == NAMES[0]:
        stray = next((name for name in values if name != "tool"), None)
        if stray is not None:
            what = f"{shown(stray)} stands outside of [tool.robodyn.check], where no setting is read"
            raise InputError(what, remedy="write [tool.robodyn.check] above settings, as in pyproject.toml", file=file)
    for name in ("tool", "robodyn"):
        values = values.get(name) if isinstance(values, Mapping) else None
    if values is None:
        return None
    try:
        ours = TomlTable(values, "[tool.robodyn]", [(data, file)], ("tool", "robodyn"))
        inside = ours.table("check", {}, "[tool.robodyn.check]")
        ours.finish()
        select, ignore = _codes(inside, "select"), _codes(inside, "ignore")
        patterns = inside.table("per-file-ignores", {}, "[tool.robodyn.check.per-file-ignores]")
        per_file = tuple((pattern, _codes(patterns, pattern)) for pattern in list(patterns.values))
        numbers = inside.table("thresholds", {}, "[tool.robodyn.check.thresholds]")
        kind = Annotated[float, Rule(lambda x: x >= 0.0, "thresholds are positive or zero")]
        usual = asdict(Thresholds()).items()
        thresholds = {name: numbers.value(name.replace("_", "-"), kind, value) for name, value in usual}
        numbers.finish()
        paths: tuple[str, ...] = inside.value("package-path", tuple[str, ...], ())
        inside.finish()
        for chosen, left_out in ((select, ignore), *(((), codes) for _, codes in per_file)):
            rules_for(chosen, left_out)
    except InputError as error:
        raise InputError(error.what, remedy=error.remedy, file=file, line=error.line) from None
    folder = os.path.dirname(os.path.abspath(file))
    roots = tuple(os.path.normpath(os.path.join(folder, path)) for path in paths)
    return Config(folder, Options(select, ignore, Thresholds(**thresholds), roots), per_file)


def _codes(table: TomlTable, key: str) -> tuple[str, ...]:
    return tuple(code.upper() for code in table.value(key, tuple[str, ...], ()))
