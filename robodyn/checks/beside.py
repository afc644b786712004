"""The descriptions that a mesh, an SRDF or macros belong to, for hooks that are told which files have changed."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path

from robodyn.checks.ros.srdf import srdf_of
from robodyn.errors import DescriptionError, NoRobotError
from robodyn.robot.urdf.document import read_document
from robodyn.robot.urdf.packages import Search
from robodyn.robot.urdf.sources import is_xacro
from robodyn.robot.urdf.xacro import no_robot, only_defines
from robodyn.support.input_file import read_input

BESIDE = (".srdf", ".stl", ".obj", ".dae", ".ply", ".glb", ".gltf")
"""Suffixes of files that belong to descriptions."""


def describing(path: str) -> list[str]:
    """Return the descriptions of the file's package that name a mesh, or whose SRDF this is, by their names; of a xacro
    file that only defines parts those that include it, through others or not, in the packages beside as well.

    Without a package.xml above the file they are looked for in its folder, in the one above, and in those in these.

    Raises:
        NoRobotError: there is none.
    """
    if is_xacro(path):
        found = sorted(map(str, _including(Path(path).absolute())))
        if not found:
            raise no_robot(path)
    else:
        belongs = _has_srdf if path.lower().endswith(".srdf") else _names
        found = [str(urdf) for urdf in _descriptions(Path(path).absolute()) if belongs(urdf, Path(path))]
    if not found:
        raise NoRobotError("no description in its package names it", remedy="name a description", file=path)
    return found if os.path.isabs(path) else [os.path.relpath(urdf) for urdf in found]


def _descriptions(path: Path) -> list[Path]:
    home = Search(str(path)).home
    return _below([] if home is None else [home], path, ".urdf")


def _below(packages: Iterable[Path], path: Path, suffix: str) -> list[Path]:
    """Return the files in packages, or near a file where there are none."""
    found = {file for package in packages for file in package.rglob(f"*{suffix}")} or {
        file for folder in path.parents[:2] for form in ("*", "*/*") for file in folder.glob(form + suffix)
    }
    return sorted(file for file in found if file.is_file())


def _including(parts: Path) -> set[Path]:
    """Return the xacro files that describe a robot and include this one, or one that does."""
    home = Search(str(parts)).home
    packages = [] if home is None else [folder.parent for folder in home.parent.glob("*/package.xml")]
    texts = {file: read_input(file) for file in _below(packages, parts, ".xacro")}
    found, reached = set[Path](), [parts]
    for one in reached:
        name = re.compile(rb"include[^>]*[\"'/\\]" + re.escape(one.name.encode()) + rb"[\"']")
        for file in [file for file, text in texts.items() if file not in (*found, *reached) and name.search(text)]:
            if only_defines(str(file)):
                reached.append(file)
            else:
                found.add(file)
    return found


def _names(urdf: Path, mesh: Path) -> bool:
    return mesh.name.encode() in read_input(urdf)


def _has_srdf(urdf: Path, srdf: Path) -> bool:
    try:
        own = srdf_of(str(urdf), read_document(urdf).root.get("name"))
    except DescriptionError:
        return False
    return own is not None and os.path.samefile(own, srdf)
