"""Which files are meant, the descriptions that meshes, SRDFs and macros belong to, and which are worth processes."""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import Any, TypeVar
from warnings import warn

from robodyn.checks.srdf import srdf_of
from robodyn.errors import DescriptionError, InputError, NoRobotError, RobodynWarning
from robodyn.robot.urdf.document import read_document
from robodyn.robot.urdf.sources import Search, is_xacro
from robodyn.robot.urdf.xacro import no_robot, only_defines
from robodyn.support.input_file import read_input
from robodyn.support.threads import cores, processes

RELATED = (".srdf", ".stl", ".obj", ".dae", ".ply", ".glb", ".gltf")
"""Suffixes of files that belong to descriptions."""
R = TypeVar("R")
_LEAST_WORK = 500_000
"""Bytes of XML in files that take longer to check than processes take to start: half a second."""
_MESH = 5_000
"""Bytes of XML that take as long as a mesh of usual size, read anew."""


def related_descriptions(path: str) -> list[str]:
    """Return the descriptions of the file's package that name a mesh, or whose SRDF this is; of a xacro file that only
    defines parts those that include it, through others or not, in the packages beside as well. Without a package.xml
    above the file they are looked for in its folder, in the one above, and in those in these. NoRobotError for none."""
    if is_xacro(path):
        found = sorted(map(str, _including(Path(path).absolute())))
        if not found:
            raise no_robot(path)
    else:
        file = Path(path).absolute()
        home = Search(str(file)).home
        descriptions = _in_packages([] if home is None else [home], file, ".urdf")
        if path.lower().endswith(".srdf"):
            found = [str(urdf) for urdf in descriptions if _has_srdf(urdf, file)]
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


def _including(parts: Path) -> set[Path]:
    """Return the xacro files that describe a robot and include this one, or one that does."""
    home = Search(str(parts)).home
    packages = [] if home is None else [folder.parent for folder in home.parent.glob("*/package.xml")]
    texts = {file: read_input(file) for file in _in_packages(packages, parts, ".xacro")}
    found, reached = set[Path](), [parts]
    for one in reached:
        name = re.compile(rb"include[^>]*[\"'/\\]" + re.escape(one.name.encode()) + rb"[\"']")
        for file in [file for file, text in texts.items() if file not in (*found, *reached) and name.search(text)]:
            if only_defines(str(file)):
                reached.append(file)
            else:
                found.add(file)
    return found


def _has_srdf(urdf: Path, srdf: Path) -> bool:
    try:
        own = srdf_of(str(urdf), read_document(urdf).root.get("name"))
    except DescriptionError:
        return False
    return own is not None and os.path.samefile(own, srdf)


def files_of(sources: Sequence[str | os.PathLike[str] | bytes]) -> list[str | bytes]:
    """Return the files in the order given; a folder's and a pattern's in the order of their names; each once.

    Of a folder all .urdf below it; where there is none, all .xacro; of a mesh, an SRDF or a xacro file of macros its
    `related_descriptions`, with a warning where there are none. A folder or a pattern without a description is an
    InputError, or a warning where others are named as well.
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
    if not os.path.isfile(path) and (os.path.exists(path) or not glob.has_magic(path)):
        return [path]
    if os.path.isfile(path):
        related = path.lower().endswith(RELATED) or (is_xacro(path) and only_defines(path))
        return related_descriptions(path) if related else [path]
    names = sorted(glob.iglob(path, recursive=True))
    if not names:
        raise InputError("nothing matches the pattern", remedy="check the name", file=path)
    return names


def _below(folder: str, suffix: str) -> list[str]:
    """The names of files below a folder; links to folders, which may lead anywhere, are not followed."""
    found = []
    for path, inner, files in os.walk(folder):
        inner[:] = [name for name in inner if name[0] != "."]
        found += [os.path.join(path, name) for name in files if name.endswith(suffix) and name[0] != "."]
    return sorted(os.path.relpath(name, folder) for name in found)


def worth_processes(files: Sequence[str | bytes]) -> bool:
    """Whether there is more work, in XML and in the meshes that it names, than starting processes is."""
    if len(files) < 2 or cores() < 2:
        return False
    work = 0
    for file in (file for file in files if not isinstance(file, bytes)):
        with suppress(OSError, ValueError, InputError):  # told when it is checked
            data = read_input(file)
            work += len(data) + _MESH * data.count(b"<mesh")
    return work > _LEAST_WORK


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
