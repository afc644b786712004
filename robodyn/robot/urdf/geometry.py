"""The shapes of a link, with the files of its meshes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from robodyn.errors import DescriptionError, InputError
from robodyn.robot.urdf.packages import package_of
from robodyn.robot.urdf.parts import Description, Geometry, Kind, Link
from robodyn.support.wording import alternatives, shown


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
    """Return the link of this name.

    Raises:
        InputError: there is none.
    """
    links = {link.name: link for link in description.links}
    if name not in links:
        raise InputError(
            f"there is no link {shown(name)}", remedy=alternatives(name, links, "links"), file=description.file
        )
    return links[name]


def link_shapes(description: Description, link: str, kind: Kind | None = None) -> tuple[Shape, ...]:
    """Return the shapes of a link in the order of the file.

    Args:
        kind: "visual" or "collision"; both if None.

    Raises:
        InputError: there is no such link.
    """
    find = description.search.find
    return tuple(
        Shape(geometry, None if geometry.filename is None else find(geometry.filename))
        for geometry in link_named(description, link).geometries
        if kind is None or geometry.kind == kind
    )


def missing_mesh(description: Description, geometry: Geometry) -> DescriptionError:
    """Return the error of a mesh whose file is not found."""
    name = geometry.filename or ""
    package = package_of(name)
    remedy = "names are relative to the description's folder"
    if package is not None and package[0]:
        remedy = f"--package-path DIR names the package {shown(package[0])} or the folder it is in"
    elif "://" in name and not name.startswith("file://"):
        remedy = "files are not fetched; save it beside the description"
    return DescriptionError(
        f"the mesh {shown(name)} is not found", remedy=remedy, file=description.file, line=geometry.line
    )
