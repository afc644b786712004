"""The shapes of a link, with the files of its meshes."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from urllib.parse import unquote

from robodyn.errors import DescriptionError, InputError
from robodyn.urdf.packages import package_folders
from robodyn.urdf.parts import Description, Geometry, Link
from robodyn.wording import alternatives, shown

Kind = Literal["visual", "collision"]
Paths = Sequence[str | os.PathLike[str]]
_PACKAGE, _FILE = ("package", "model"), "file"


@dataclass(frozen=True, slots=True)
class Shape:
    """A shape of a link.

    Attributes:
        geometry: as described: kind, pose, sizes, file name, scale, and the line.
        path: the file of a mesh; None where it is not found, and of other shapes.
    """

    geometry: Geometry
    path: Path | None = None

    @property
    def missing(self) -> bool:
        """Whether this is a mesh without a file."""
        return self.geometry.filename is not None and self.path is None


def link_named(description: Description, name: str) -> Link:
    """The link of this name.

    Raises:
        InputError: there is none.
    """
    links = {link.name: link for link in description.links}
    if name not in links:
        raise InputError(
            f"there is no link {shown(name)}", remedy=alternatives(name, links, "links"), file=description.file
        )
    return links[name]


def link_shapes(
    description: Description, link: str, kind: Kind | None = None, package_paths: Paths = ()
) -> tuple[Shape, ...]:
    """The shapes of a link in the order of the file.

    Args:
        kind: "visual" or "collision"; both if None.
        package_paths: see `resolve`.

    Raises:
        InputError: there is no such link.
    """
    folder = Path(description.file).parent
    return tuple(
        Shape(geometry, None if geometry.filename is None else resolve(geometry.filename, folder, package_paths))
        for geometry in link_named(description, link).geometries
        if kind is None or geometry.kind == kind
    )


def resolve(uri: str, folder: str | os.PathLike[str], package_paths: Paths = ()) -> Path | None:
    """The file that a URDF means by the name of a mesh; None if there is none on this machine.

    A plain name is relative to `folder`. `package://NAME/REST` (and Gazebo's `model://`) is REST in the package NAME,
    which is looked for in `package_paths`, each a package or a folder of packages, then in ROS_PACKAGE_PATH, then in
    the folders above `folder`. `file://` is a path from the root. Nothing is fetched: other schemes have no file.
    """
    return next((path for path in _candidates(uri, Path(folder), package_paths) if _is_file(path)), None)


def missing_mesh(description: Description, geometry: Geometry) -> DescriptionError:
    """The error of a mesh whose file is not found."""
    name = geometry.filename or ""
    package = _package(name)
    remedy = "names are relative to the description's folder"
    if package is not None:
        remedy = f"--package-path DIR names the package {shown(package[0])} or the folder it is in"
    elif "://" in name and not name.startswith(f"{_FILE}://"):
        remedy = "files are not fetched; save it beside the description"
    return DescriptionError(
        f"the mesh {shown(name)} is not found", remedy=remedy, file=description.file, line=geometry.line
    )


def _candidates(uri: str, folder: Path, package_paths: Paths) -> Iterator[Path]:
    scheme, separator, rest = uri.partition("://")
    package = _package(uri)
    if not separator:
        yield folder / uri
    elif scheme == _FILE:
        path = rest if rest.startswith("/") else rest[rest.find("/") :]
        yield from (Path(path), Path(unquote(path)))
    elif package is not None:
        yield from (root / package[1] for root in package_folders(package[0], folder, package_paths))


def _package(uri: str) -> tuple[str, str] | None:
    """Name of the package and the path in it, of package://name/path."""
    scheme, separator, rest = uri.partition("://")
    name, _, path = rest.partition("/")
    return (name, path.lstrip("/")) if separator and scheme in _PACKAGE and name else None


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False
