"""Which files are meant, by which settings of their project they are checked, and which are worth processes.

Settings are in `[tool.robodyn.check]` of robodyn.toml or pyproject.toml, the nearest above a description.
"""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Any
from warnings import warn

from robodyn.checks.catalogue import rules_for
from robodyn.checks.context import Options, Thresholds
from robodyn.checks.srdf import document_or_none, srdf_of
from robodyn.errors import InputError, NoRobotError, RobodynWarning, unreadable
from robodyn.robot.urdf.sources import Search, is_xacro
from robodyn.robot.urdf.xacro import no_robot, only_defines
from robodyn.scene.scene import Rule
from robodyn.scene.toml_table import TomlTable, read_toml
from robodyn.support.input_file import read_input
from robodyn.support.threads import cores
from robodyn.support.wording import count, listed_paths, shown

RELATED = (".srdf", ".stl", ".obj", ".dae", ".ply", ".glb", ".gltf")  # suffixes of files that belong to descriptions
_LEAST_WORK = 100_000  # bytes of XML that take longer to check, with meshes, than processes take to start
_INCLUDE = re.compile(rb"""<(?:xacro:)?include\s[^<>]*?filename\s*=\s*["']([^"'<]+)["']""")
_FIND = re.compile(r"\$\(find ([^)]*)\)")
_MOST_SOURCE = 1 << 24
NAMES = ("robodyn.toml", "pyproject.toml")  # what is looked for in each folder, in this order


def related_descriptions(path: str) -> list[str]:
    """Return the descriptions of the file's package that name a mesh, or whose SRDF this is; of a xacro file those that
    include it, through others or not, in the packages beside as well. Without a package.xml above the file they are
    looked for in its folder, in the one above, and in those in these. NoRobotError for none."""
    if is_xacro(path):
        part = Path(path).absolute()
        home = Search(str(part)).home
        packages = [] if home is None else [folder.parent for folder in home.parent.glob("*/package.xml")]
        above, reached = includers({*_in_packages(packages, part, ".xacro"), part}), [part]
        for one in reached:
            reached += sorted(above[one].difference(reached))
        found = sorted({str(file) for file in reached[1:] if not above[file] and not only_defines(str(file))})
        if not found:
            raise no_robot(path)
    else:
        file = Path(path).absolute()
        home = Search(str(file)).home
        descriptions = _in_packages([] if home is None else [home], file, ".urdf")
        if path.lower().endswith(".srdf"):
            documents = {str(urdf): document_or_none(urdf) for urdf in descriptions}
            own = {name: srdf_of(name, each.root.get("name")) for name, each in documents.items() if each is not None}
            found = [name for name, each in own.items() if each is not None and os.path.samefile(each.file, file)]
        else:
            found = [str(urdf) for urdf in descriptions if file.name.encode() in read_input(urdf)]
    if not found:
        raise NoRobotError("no description in its package names it", remedy="name a description", file=path)
    return found if os.path.isabs(path) else [os.path.relpath(urdf) for urdf in found]


def _in_packages(packages: Iterable[Path], path: Path, suffix: str) -> list[Path]:
    found = {file for package in packages for file in package.rglob(f"*{suffix}")} or {
        file for folder in path.parents[:2] for form in ("*", "*/*") for file in folder.glob(form + suffix)
    }
    return sorted(file for file in found if file.is_file())


def includers(files: Iterable[Path]) -> dict[Path, set[Path]]:
    """Return of each xacro file those of the files that include it, as far as their texts say: what is computed in a
    name may be any folder, `$(find NAME)` is one of that name if there is one."""
    above: dict[Path, set[Path]] = {file: set() for file in files}
    named: dict[str, list[Path]] = {}
    for file in above:
        named.setdefault(file.name, []).append(file)
    for file in above:
        with suppress(OSError, ValueError, InputError):  # told when it is checked
            for written in _INCLUDE.findall(read_input(file, _MOST_SOURCE)):
                for other in _included(written.decode(errors="replace"), file, named):
                    if other != file:
                        above[other].add(file)
    return above


def _included(written: str, by: Path, named: dict[str, list[Path]]) -> list[Path]:
    alike = named.get(os.path.basename(written), [])
    if "$" not in written:
        return [file for file in alike if file == Path(os.path.normpath(by.parent / written))]
    tail = os.path.normpath(re.split(r"[)}]", written)[-1].lstrip("/"))
    found = [file for file in alike if file.as_posix().endswith("/" + tail)]
    package = _FIND.match(written)
    return [file for file in found if package is not None and package[1] in file.parts] or found


def defined_beside(path: str, names: Iterable[str]) -> str | None:
    """Return the xacro file of the folder or package that has elements of all these names, if one has."""
    file = Path(path).absolute()
    home = Search(path).home
    wanted = [re.compile(rb"<link\s[^<>]*?name\s*=\s*[\"']" + re.escape(name.encode()) + rb"[\"']") for name in names]
    for other in _in_packages([file.parent if home is None else home], file, ".xacro"):
        with suppress(OSError, ValueError, InputError):
            text = b"" if other == file else read_input(other, _MOST_SOURCE)
            if all(one.search(text) for one in wanted):
                return str(other)
    return None


def files_of(sources: Sequence[str | os.PathLike[str] | bytes], including: bool = False) -> list[str | bytes]:
    """Return the files in the order given; a folder's and a pattern's in the order of their names; each once. Of a
    folder all .urdf below it, and all .xacro that no other includes; of a mesh, an SRDF or a xacro file of macros its
    `related_descriptions`, with a warning where there are none; with `including` also of one that others include. A
    folder or a pattern without a description is an InputError, or a warning where others are named as well."""
    found: dict[str | bytes, None] = {}
    errors: list[InputError] = []
    for source in sources:
        try:
            named = [source] if isinstance(source, bytes) else _expanded(os.fspath(source), including)
            found.update(dict.fromkeys(named))
        except InputError as error:
            errors.append(error)
    fatal = [error for error in errors if not isinstance(error, NoRobotError)]
    if fatal and not found:
        raise fatal[0]
    for without in errors:
        warn(f"{without}: skipped", RobodynWarning, stacklevel=2)
    return list(found)


def _expanded(path: str, including: bool) -> list[str]:
    if os.path.isdir(path):
        below = []
        for folder, inner, names in os.walk(path):  # links to folders, which may lead anywhere, are not followed
            inner[:] = [name for name in inner if name[0] != "."]
            below += [os.path.join(folder, name) for name in names if name[0] != "."]
        urdfs, xacros = ([file for file in sorted(below) if file.endswith(suffix)] for suffix in (".urdf", ".xacro"))
        if not urdfs and not xacros:
            raise InputError("no .urdf and no .xacro in the folder", remedy="check the name", file=path)
        above = includers(Path(file).absolute() for file in xacros)
        parts = [file for file in xacros if above[Path(file).absolute()] or only_defines(file)]
        if parts:
            what = count(len(parts), "xacro file is part of others", "xacro files are parts of others")
            warn(f"{path}: {what}, judged where they are included: {listed_paths(parts)}", RobodynWarning, stacklevel=2)
        return sorted({*urdfs, *xacros}.difference(parts))
    if not os.path.isfile(path) and (os.path.exists(path) or not glob.has_magic(path)):
        return [path]
    if os.path.isfile(path):
        if path.lower().endswith(RELATED) or (is_xacro(path) and only_defines(path)):
            return related_descriptions(path)
        if including and is_xacro(path):
            with suppress(NoRobotError):  # no other includes it
                return related_descriptions(path)
        return [path]
    names = sorted(glob.iglob(path, recursive=True))
    if not names:
        raise InputError("nothing matches the pattern", remedy="check the name", file=path)
    return names


def worth_processes(files: Sequence[str | bytes]) -> bool:
    """Whether there is more work, by the size of the files, than starting processes is."""
    sizes = [os.path.getsize(file) for file in files if not isinstance(file, bytes) and os.path.isfile(file)]
    return min(len(files), cores()) > 1 and sum(sizes) > _LEAST_WORK


@dataclass(frozen=True)
class Config:
    """What a project has set: the folder of its file, to which patterns and package paths are relative; options; and by
    patterns of files the codes that are ignored in those."""

    folder: str
    options: Options
    per_file: tuple[tuple[str, tuple[str, ...]], ...] = ()

    def of(self, path: str, given: Options) -> Options:
        """Return the options for one file, `given` those of the call: its `select` and package path win, its `ignore`
        is added."""
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
    """Return the settings that hold in a folder: of the nearest file, there or above, that has any; `known` grows."""
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
    """Return the settings in a file; InputError where it cannot be read, or has no such table, or a key that is not
    understood."""
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
