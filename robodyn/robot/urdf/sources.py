"""The bytes of a description, xacro files expanded; and the files that it names, beside it or in packages of ROS."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain, tee
from pathlib import Path
from urllib.parse import unquote

from robodyn.errors import DescriptionError
from robodyn.support.input_file import read_input

EXPANDED = " (expanded)"
"""What stands after the name of a xacro file whose lines are those of its expansion."""
VARIABLES = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH", "CMAKE_PREFIX_PATH")
"""The environment variables that say where packages are: the first names folders of packages, the others prefixes of
installations, whose packages are in share/."""
_NAME = re.compile(rb"<name>\s*([^<]*?)\s*</name>")
_PACKAGE = re.compile(r"[\w.+-]{1,255}")
_MOST_READ = 1 << 16
_DEEPEST, _MOST_FOLDERS = 4, 20_000
"""How far below a folder packages are looked for, and in how many folders at most."""


@dataclass(frozen=True, eq=False)
class Search:
    """The one way in which names of meshes and packages become files.

    Attributes:
        file: of the description, which need not be there: names are relative to its folder, then to the one where a
            symbolic link leads.
        package_paths: packages, or folders of packages, that are looked at first.
        expanded_to: the folder that the expansion of a xacro file is written to, which names are relative to; empty
            where that is not known.
    """

    file: str
    package_paths: tuple[str, ...] = ()
    expanded_to: str = ""
    _known: dict[str, Iterator[Path]] = field(default_factory=dict, repr=False)

    def __reduce__(self) -> tuple[type[Search], tuple[str, tuple[str, ...], str]]:
        return Search, (self.file, self.package_paths, self.expanded_to)

    def find(self, uri: str) -> Path | None:
        """Return the file that a description means by the name of a mesh; None if there is none on this machine.

        A plain name is relative to a folder of the description or, where it is not there, to its package or a folder
        above it, up to the repository's. `package://NAME/REST` (and Gazebo's `model://`) is REST in the package NAME
        or, where that is nowhere, in a folder above; `file://` is a path from the root. Nothing is fetched.
        """
        return next((path for path in self._candidates(uri) if os.path.isfile(path)), None)

    @cached_property
    def folders(self) -> tuple[Path, ...]:
        """The folder in which the description is named, and the one where it is, if a symbolic link leads there."""
        file = self.file.removesuffix(EXPANDED)
        named, real = Path(file).parent, Path(os.path.realpath(file)).parent
        return (named,) if real == named.absolute() else (named, real)

    def packages(self, name: str) -> Iterator[Path]:
        """Return the folders that may be the package of this name, the likeliest first; they need not exist.

        Of the package paths, then of ROS_PACKAGE_PATH: the path itself, and what is below it. Then PREFIX/share/NAME
        and PREFIX/NAME/share/NAME of AMENT_PREFIX_PATH, COLCON_PREFIX_PATH and CMAKE_PREFIX_PATH. Then the folders
        above the description, and what is in them. Then, by their package.xml, the packages beside its own, and those
        below the repository or workspace (a folder with .git, or src) that it is in. A folder is the package whose name
        its package.xml says or, without one, which it has itself.
        """
        self._known[name], again = tee(self._known.get(name) or self._possible(name))
        return again

    def share(self, name: str) -> Path | None:
        """Return the folder of a package for those who ask for no file in it: the first with a package.xml, or the
        first."""
        found = [path for path in self.packages(name) if os.path.isdir(path)]
        return next((path for path in found if package_name(path) is not None), found[0] if found else None)

    @property
    def home(self) -> Path | None:
        """The package that the description is in: the nearest folder above it with a package.xml."""
        return home_of(*self._above())

    @property
    def knows_packages(self) -> bool:
        """Whether the call or the environment says where packages are."""
        return bool(self.package_paths or any(map(listed, VARIABLES)))

    @property
    def neighbours(self) -> list[str]:
        """The names of the description's package and of those beside it."""
        folders = [] if self.home is None else [self.home, *_folders_in(self.home.parent)]
        return list(dict.fromkeys(filter(None, map(package_name, folders))))

    def _candidates(self, uri: str) -> Iterator[Path]:
        scheme, separator, rest = uri.partition("://")
        package = package_of(uri)
        if not separator:
            yield from (folder / uri for folder in ((Path(self.expanded_to),) if self.expanded_to else self.folders))
            if uri and not os.path.isabs(uri):
                yield from (folder / uri for folder in self.around)
        elif scheme == "file":
            path = rest if rest.startswith("/") else rest[rest.find("/") :]
            yield from (Path(path), Path(unquote(path)))
        elif package is not None and package[0]:
            yield from (folder / package[1] for folder in self.packages(package[0]))
            if _PACKAGE.fullmatch(package[0]) and not any(map(os.path.isdir, self.packages(package[0]))):
                yield from (folder / package[1] for folder in (*self.folders, *self.around))

    def _possible(self, name: str) -> Iterator[Path]:
        for path in map(Path, (*self.package_paths, *listed(VARIABLES[0]))):
            yield from _here(path, name)
            yield from _below(path, name)
        for prefix in map(Path, chain.from_iterable(map(listed, VARIABLES[1:]))):
            yield from (prefix / "share" / name, prefix / name / "share" / name)
        for path in self._above():
            yield from _here(path, name)
        if self.home is not None:
            yield from (path for path in _folders_in(self.home.parent) if package_name(path) == name)
        workspace = next((path for path in self._above() if path.name == "src" or (path / ".git").exists()), None)
        if workspace is not None:
            yield from (path for path in _below(workspace, name) if package_name(path) is not None)

    @cached_property
    def around(self) -> tuple[Path, ...]:
        """The package of the description, and the folders above it up to the repository, four at most."""
        found = [] if self.home is None else [self.home]
        for above in Path(os.path.abspath(self.file.removesuffix(EXPANDED))).parent.parents[:_DEEPEST]:
            if above.parent == above:
                break
            found.append(above)
            if (above / ".git").exists():
                break
        return tuple(dict.fromkeys(found))

    def _above(self) -> Iterator[Path]:
        for folder in (*self.folders, *self._entered):
            whole = folder.absolute()
            yield from (whole, *whole.parents)

    @property
    def _entered(self) -> tuple[Path, ...]:
        """The folder of the description by way of the symbolic link through which the current folder was entered."""
        entered = os.environ.get("PWD", "")
        try:
            through = os.path.isabs(entered) and entered != os.getcwd() and os.path.samefile(entered, os.curdir)
        except OSError:
            return ()
        return (Path(entered, self.file).parent,) if through and not os.path.isabs(self.file) else ()


def package_of(uri: str) -> tuple[str, str] | None:
    """Return the package's name, perhaps empty, and the path in it, of `package://NAME/PATH`; None of other names."""
    scheme, separator, rest = uri.partition("://")
    name, _, path = rest.partition("/")
    return (name, path.lstrip("/")) if separator and scheme in ("package", "model") else None


def listed(variable: str) -> list[str]:
    """Return the folders that an environment variable lists."""
    return [entry for entry in os.environ.get(variable, "").split(os.pathsep) if entry]


def _here(folder: Path, name: str) -> tuple[Path, ...]:
    return (folder, folder / name) if _is_package(folder, name) else (folder / name,)


def _below(root: Path, name: str) -> Iterator[Path]:
    """Yield packages of this name below a folder, the nearest first; none is within another."""
    level, seen = [root], 0
    for _ in range(_DEEPEST):
        level = [sub for folder in level if package_name(folder) is None for sub in _folders_in(folder)]
        seen += len(level)
        yield from (folder for folder in level if _is_package(folder, name))
        if seen > _MOST_FOLDERS:
            return


def _folders_in(folder: Path) -> list[Path]:
    try:
        with os.scandir(folder) as entries:
            names = [entry.name for entry in entries if entry.name[:1] != "." and entry.is_dir()]
    except (OSError, ValueError):
        return []
    return [folder / name for name in sorted(names)]


def _is_package(folder: Path, name: str) -> bool:
    manifest = package_name(folder)
    return folder.name == name if manifest is None else manifest == name


def package_name(folder: Path) -> str | None:
    """Return the name in the package.xml of a folder, empty where it says none; None without one."""
    try:
        found = _NAME.search(read_input(folder / "package.xml", _MOST_READ))
    except (OSError, ValueError):
        return None
    return "" if found is None else found[1].decode(errors="replace")


def home_of(*folders: Path) -> Path | None:
    """Return the first of some folders with a package.xml."""
    return next((path for path in folders if package_name(path) is not None), None)


def is_xacro(source: object) -> bool:
    """Return whether this is the path of a xacro file."""
    return isinstance(source, (str, os.PathLike)) and os.fspath(source).lower().endswith(".xacro")


def read_source(source: str | os.PathLike[str] | bytes, name: str | None) -> tuple[str, bytes]:
    """Return the name to show in messages, and the bytes."""
    if isinstance(source, bytes):
        return name or "<stdin>", source
    path = os.fspath(source)
    file = name or path
    try:
        return file, read_input(path, typed=True)
    except FileNotFoundError:
        remedy = "check the name" if os.path.isdir(os.path.dirname(path) or os.curdir) else "check the folder"
        remedy = "give a path, or the XML as bytes" if path.lstrip().startswith("<") else remedy
        what = "there is no such file"
    except IsADirectoryError:
        what, remedy = "this is a folder, not a file", "give a URDF file"
    except PermissionError:
        what, remedy = "no permission to read the file", "change its mode"
    except OSError as error:
        what, remedy = f"cannot read the file: {error.strerror}", "check the name and the disk"
    except ValueError as error:
        what, remedy = f"this is not a file name: {error}", "check the name"
    raise DescriptionError(what, remedy=remedy, file=file)


_UTF_16 = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"<\0": "utf-16-le", b"\0<": "utf-16-be"}


def as_utf8(data: bytes) -> tuple[bytes, bool]:
    """Return UTF-16 transcoded to UTF-8, everything else as it is; and whether it was transcoded."""
    encoding = _UTF_16.get(data[:2])
    return (data, False) if encoding is None else (data.decode(encoding).encode(), True)


OTHER_FORMATS = {"mujoco": "MJCF", "sdf": "SDF"}
"""Formats beside URDF, by the root element."""
_TAG_NAME = re.compile(rb"<([A-Za-z_][\w.:-]*)")


def root_tag(data: bytes) -> str:
    """Return the tag of the first element of XML; empty where there is none, or a document type before it."""
    try:
        data, at = as_utf8(data)[0].removeprefix(b"\xef\xbb\xbf"), 0
    except UnicodeError:
        return ""
    while True:
        while data[at : at + 1].isspace():
            at += 1
        end = {b"<?": b"?>", b"<!": b"-->"}.get(data[at : at + 2])
        if end is None:
            found = _TAG_NAME.match(data, at)
            return "" if found is None else found[1].decode()
        if not data.startswith((b"<?", b"<!--"), at) or (behind := data.find(end, at)) < 0:
            return ""
        at = behind + len(end)


LONGEST = 1 << 21
"""Bytes of the longest comment that is read, and the most from the beginning of one tag to that of the next.

expat scans a token that is not complete yet again with every further megabyte: 100 MB in one attribute take it half a
minute.
"""
_STRETCH = re.compile(rb"(<!--.*?(?:-->|\Z))[^<]*|<[^<]*|[^<]+", re.DOTALL)
"""A comment or a tag, with the text that follows it."""
_PIECE = re.compile(rb""">|"[^"]*(?:"|\Z)|'[^']*(?:'|\Z)""")


def long_token(data: bytes) -> tuple[int, int, str] | None:
    """Return bytes [start, end) and kind of the first token that makes it more than `LONGEST` to the next tag."""
    for stretch in _STRETCH.finditer(data) if len(data) > LONGEST else ():
        start, end = stretch.span()
        if end - start <= LONGEST:
            continue
        behind = max(start, stretch.end(1))
        if behind - start > LONGEST:
            return start, behind, "comment"
        if behind > start or not data.startswith(b"<", start):
            return behind, end, "text"
        for piece in _PIECE.finditer(data, start, end):
            if piece.group() == b">":
                return piece.end(), end, "text"
            if piece.end() - piece.start() > LONGEST // 2:
                closed = data[piece.end() - 1] == data[piece.start()]
                return piece.start() + 1, piece.end() - closed, "attribute"
            if piece.end() - start > LONGEST:
                break
        return start, end, "tag"
    return None
