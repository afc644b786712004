"""The descriptions that a mesh or an SRDF belongs to, for hooks that are told which files have changed."""

from __future__ import annotations

import os
from pathlib import Path

from robodyn.checks.ros.srdf import srdf_of
from robodyn.errors import DescriptionError, NoRobotError
from robodyn.robot.urdf.document import read_document
from robodyn.robot.urdf.packages import Search
from robodyn.support.input_file import read_input

BESIDE = (".srdf", ".stl", ".obj", ".dae", ".ply", ".glb", ".gltf")
"""Suffixes of files that belong to descriptions."""


def describing(path: str) -> list[str]:
    """Return the descriptions of the file's package that name a mesh, or whose SRDF this is, by their names.

    Without a package.xml above the file they are looked for in its folder, in the one above, and in those in these.

    Raises:
        NoRobotError: there is none.
    """
    belongs = _has_srdf if path.lower().endswith(".srdf") else _names
    found = [str(urdf) for urdf in _descriptions(Path(path).absolute()) if belongs(urdf, Path(path))]
    if not found:
        raise NoRobotError("no description in its package names it", remedy="name a description", file=path)
    return found if os.path.isabs(path) else [os.path.relpath(urdf) for urdf in found]


def _descriptions(path: Path) -> list[Path]:
    home = Search(str(path)).home
    if home is not None:
        found = set(home.rglob("*.urdf"))
    else:
        found = {urdf for folder in path.parents[:2] for form in ("*.urdf", "*/*.urdf") for urdf in folder.glob(form)}
    return sorted(urdf for urdf in found if urdf.is_file())


def _names(urdf: Path, mesh: Path) -> bool:
    return mesh.name.encode() in read_input(urdf)


def _has_srdf(urdf: Path, srdf: Path) -> bool:
    try:
        own = srdf_of(str(urdf), read_document(urdf).root.get("name"))
    except DescriptionError:
        return False
    return own is not None and os.path.samefile(own, srdf)
