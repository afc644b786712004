"""What a xacro file may read: files of its package, of folders that the call names, and of packages; few variables."""

from __future__ import annotations

import errno
import glob
import os
import re
import stat
from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

from robodyn.robot.urdf.packages import VARIABLES, Search, home_of, package_name
from robodyn.robot.urdf.xacro_values import RefusedError
from robodyn.support.input_file import read_input
from robodyn.support.wording import shown, shown_path

MOST_FILES = 1_000
"""Files that an expansion reads, the same one as often as it is read."""
MOST_BYTES = 1 << 24
"""Of one of them."""
MOST_YAML = 1 << 20
"""Of a file of YAML, of which Python reads a megabyte in some seconds."""
_PACKAGE = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.+-]*")
_NAMED = "--package-path DIR names a folder to read from"


class Reach:
    """Reads for an expansion: what is trusted any regular file and any variable.

    Links followed, a file must lie in the package of the description (its folder, without a package.xml), a package
    path, a package found by its package.xml or another copy of one of these; or an argument names it from the root on.
    Nothing is read below names that begin with a dot. Arguments stand for variables of their names as well.
    """

    def __init__(
        self, file: str, package_paths: Sequence[str], arguments: Mapping[str, str], trusted: bool = False
    ) -> None:
        self._search = Search(file, tuple(package_paths))
        self._arguments, self._trusted = arguments, trusted
        whole = map(Path.absolute, self._search.folders)
        homes = [home_of(folder, *folder.parents) or folder for folder in whole]
        above = [str(home) for home in homes if os.path.realpath(home) != os.path.realpath(os.sep)]
        named = [value for value in arguments.values() if os.path.isabs(value) and os.path.isfile(value)]
        roots = [file, *above, *package_paths, *named]
        self._roots = set(map(os.path.realpath, roots))
        self._names = {name for name in map(package_name, homes) if name}
        self._read = 0

    def read(self, path: str, most: int = MOST_BYTES) -> bytes:
        """Return the bytes of a file; RefusedError where it is out of reach, or too much."""
        self._check(path)
        status = os.stat(path)
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "this is no regular file", path)
        self._read += 1
        if self._read > MOST_FILES:
            raise RefusedError(f"reading more than {MOST_FILES} files")
        if status.st_size > most:
            raise RefusedError(f"reading {shown_path(path)}, of more than {most} bytes,")
        return read_input(path, most)

    def opened(self, path: str, *_: Any, **__: Any) -> BytesIO:
        """Return a file of YAML, open: what stands for `open` in xacro, which reads XML by `read`."""
        return BytesIO(self.read(path, MOST_YAML))

    def matching(self, pattern: str) -> list[str]:
        """Return the files that match the pattern of an include."""
        plain = re.split(r"[*?\[]", pattern, maxsplit=1)[0]
        self._check(os.path.dirname(plain))
        if os.pardir in pattern[len(plain) :].replace(os.sep, "/").split("/"):
            raise RefusedError(f"looking for {shown_path(pattern)}, which leads up again,")
        return glob.glob(pattern)

    def package(self, name: str) -> str:
        """Return the folder of a package, of which files may be read from then on.

        Raises:
            RefusedError: it is a folder without package.xml, which is out of reach.
        """
        found = self._search.share(name) if self._trusted or _PACKAGE.fullmatch(name) else None
        if found is None:
            raise LookupError(f"the package {shown(name)} is not found")
        folder = os.path.realpath(found)
        if not self._trusted and not self._within(folder):
            if package_name(found) is None:
                what = f"taking {shown_path(folder)}, without a package.xml, for the package {shown(name)}"
                raise RefusedError(what, _NAMED)
            self._roots.add(folder)
            self._names.add(name)
        return os.path.abspath(found)

    def variable(self, name: str) -> str | None:
        """Return an argument of that name, or a variable that says where packages are; another one is refused."""
        if name in self._arguments:
            return self._arguments[name]
        if not self._trusted and name not in VARIABLES:
            remedy = f"--xacro-arg {name if name.isidentifier() else 'NAME'}:=VALUE gives it one"
            raise RefusedError(f"asking for the variable {shown(name)} of the environment", remedy)
        return os.environ.get(name)

    def _check(self, path: str) -> None:
        """Raise if a file is out of reach, whether it is there or not."""
        real = os.path.realpath(path or os.curdir)
        if self._trusted or self._within(real):
            return
        home = home_of(*Path(real).parents)
        if home is not None and package_name(home) in self._names and _shows(str(home), real):
            return
        leads = "" if real == os.path.abspath(path) else f", which leads to {shown_path(real)}"
        within = any(Path(real).is_relative_to(root) for root in self._roots)
        where = "below a name that begins with a dot" if within else "outside of the packages that were found"
        raise RefusedError(f"reading {shown_path(path)}{leads}, {where},", "" if within else _NAMED)

    def _within(self, real: str) -> bool:
        return any(_shows(root, real) for root in self._roots)


def _shows(root: str, real: str) -> bool:
    """Return whether a file is a folder, or below it without a name that begins with a dot on the way."""
    inner = Path(real)
    return inner.is_relative_to(root) and not any(part.startswith(".") for part in inner.relative_to(root).parts)
