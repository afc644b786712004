"""Expanding xacro files, by way of xacrodoc where that is installed."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from typing import Any

from robodyn.errors import InputError
from robodyn.urdf.packages import Search
from robodyn.wording import alternatives, shown


def expanded(path: str, package_paths: Sequence[str] = (), args: Mapping[str, str] | None = None) -> bytes:
    """The URDF that a xacro file stands for.

    The text is what the command `xacro FILE` prints, so that lines can be looked up there. Packages that it includes
    from are looked for as those of meshes are. xacro evaluates the file's expressions in Python, with a restricted set
    of names.

    Args:
        args: values of its arguments by name; defaults hold for the others.

    Raises:
        InputError: xacrodoc is not installed, the file cannot be read or expanded, or has no such argument.
    """
    if not os.path.isfile(path):
        raise InputError("there is no such file", remedy="check the name", file=path)
    try:
        import xacrodoc  # its xacro needs no ROS
        from xacro import process_file
    except ImportError:
        remedy = f"pip install 'robodyn[xacro]', or expand it first: xacro {path} > robot.urdf"
        raise InputError("to read a xacro file xacrodoc is needed", remedy=remedy, file=path) from None
    given = _Arguments(args or {})
    xacrodoc.packages._finder = _Packages(path, package_paths)
    try:
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            text: str = process_file(path, mappings=given).toprettyxml(indent="  ")
    except (Exception, SystemExit) as error:
        what = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"xacro cannot expand it: {what}", remedy=_remedy(path, what), file=path) from None
    for name in args or ():
        if name not in given.known:
            remedy = alternatives(name, given.known, "arguments")
            raise InputError(f"the file has no argument {shown(name)}", remedy=remedy, file=path)
    return text.encode()


class _Packages:
    """What xacro asks for the folder of a package."""

    def __init__(self, path: str, package_paths: Sequence[str]) -> None:
        self._search = Search(path, tuple(package_paths))

    def get_path(self, name: str) -> str:
        found = self._search.share(name)
        if found is None:
            raise LookupError(f"the package {shown(name)} is not found")
        return os.path.abspath(found)


class _Arguments(dict[str, Any]):
    """Values of arguments that note which ones a file has: xacro asks whether one has a value, or for it."""

    def __init__(self, given: Mapping[str, str]) -> None:
        super().__init__(given)
        self.known: dict[str, None] = {}

    def __contains__(self, name: object) -> bool:
        self.known[str(name)] = None
        return super().__contains__(name)

    def __getitem__(self, name: str) -> Any:
        self.known[name] = None
        return super().__getitem__(name)


def _remedy(path: str, what: str) -> str:
    if "the package '" in what:
        return "--package-path DIR names the package or the folder it is in"
    if "argument" in what:
        return "--xacro-arg NAME:=VALUE gives it a value"
    return f"try: xacro {path}"
