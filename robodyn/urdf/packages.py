"""Where the folders of ROS packages are, without ROS: on search paths and above a file."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

_NAME = re.compile(rb"<name>\s*([^<]*?)\s*</name>")
_MANIFEST = "package.xml"
_MOST_READ = 1 << 16


def package_folders(name: str, folder: Path, package_paths: Sequence[str | os.PathLike[str]] = ()) -> Iterator[Path]:
    """Folders that the package of this name may be, the likeliest first; they need not exist.

    Of the package paths, then of ROS_PACKAGE_PATH, then of the folders above `folder`: the path itself where its
    package.xml or, without one, its last part has the name, and its subfolder of this name; of the first two also such
    subfolders one level deeper, as in a workspace of repositories.
    """
    listed = [entry for entry in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if entry]
    for path in map(Path, (*package_paths, *listed)):
        yield from _here(path, name)
        yield from (folder / name for folder in _folders_in(path))
    whole = folder.absolute()
    for path in (whole, *whole.parents):
        yield from _here(path, name)


def _folders_in(folder: Path) -> list[Path]:
    try:
        return sorted(path for path in folder.iterdir() if path.is_dir())
    except (OSError, ValueError):
        return []


def _here(folder: Path, name: str) -> Iterator[Path]:
    if _is_package(folder, name):
        yield folder
    yield folder / name


def _is_package(folder: Path, name: str) -> bool:
    try:
        with open(folder / _MANIFEST, "rb") as manifest:
            found = _NAME.search(manifest.read(_MOST_READ))
    except (OSError, ValueError):
        return folder.name == name
    return found is not None and found[1] == name.encode()
