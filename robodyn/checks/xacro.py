"""Expanding xacro files, by way of xacrodoc where that is installed."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO

from robodyn.errors import InputError

SUFFIX = ".xacro"
EXPANDED = " (expanded)"
"""What stands after the name of a file whose lines are those of its expansion."""


def is_xacro(source: object) -> bool:
    return isinstance(source, str) and source.lower().endswith(SUFFIX)


def expanded(path: str, package_path: Sequence[str] = ()) -> bytes:
    """The URDF that a xacro file stands for, with the defaults of its arguments.

    The text is what the command `xacro FILE` prints, so that lines can be looked up there. Packages that it includes
    from are looked for in the package path, in the folders above the file, and where ROS has them. xacro evaluates the
    file's expressions in Python, with a restricted set of names.

    Raises:
        InputError: xacrodoc is not installed, or the file cannot be read or expanded.
    """
    if not os.path.isfile(path):
        raise InputError("there is no such file", remedy="check the name", file=path)
    try:
        from xacro import process_file
        from xacrodoc import packages  # lets xacro find packages without ROS
    except ImportError:
        remedy = f"pip install 'robodyn[xacro]', or expand it first: xacro {path} > robot.urdf"
        raise InputError("to check a xacro file xacrodoc is needed", remedy=remedy, file=path) from None
    packages.reset()
    packages.walk_up_from(os.path.abspath(path))
    packages.look_in([os.path.abspath(folder) for folder in package_path])
    try:
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            text: str = process_file(path).toprettyxml(indent="  ")
    except (Exception, SystemExit) as error:
        what = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"xacro cannot expand it: {what}", remedy=f"try: xacro {path}", file=path) from None
    return text.encode()
