"""PLY, ASCII and binary: the elements `vertex` and `face`; others are passed over."""

from __future__ import annotations

import numpy as np

from robodyn.errors import MeshError
from robodyn.solids.mesh.lines import Integers
from robodyn.solids.mesh.ply_ascii import read_text
from robodyn.solids.mesh.ply_binary import read_binary
from robodyn.solids.mesh.ply_header import Element, Header, Property, read_header
from robodyn.solids.mesh.polygons import triangles_of
from robodyn.solids.mesh.source import Source
from robodyn.solids.mesh.triangles import Corners, IndexedTriangles

_AXES = ("x", "y", "z")
_INDICES = ("vertex_indices", "vertex_index")


def read_ply(source: Source, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
    """The faces of a PLY, with coordinates of the type that the header names.

    Raises:
        MeshError: the header or the data are malformed, or fewer data follow than the header promises.
    """
    header = read_header(source)
    wanted = {"vertex": _AXES, "face": (_list_of_faces(source, header),)}
    read = read_text if header.encoding == "ascii" else read_binary
    found = read(source, header, wanted)
    vertices = _vertices(found)
    sizes, corners = found["face", wanted["face"][0]]
    return triangles_of(
        source.name,
        vertices,
        corners,
        sizes,
        significand=24 if vertices.dtype == np.float32 else 53,
        scale=scale,
        notes=notes,
    )


def _vertices(found: dict[tuple[str, str], tuple[Integers, Corners]]) -> Corners:
    columns = [found["vertex", axis][1] for axis in _AXES]
    kind = np.float32 if all(column.dtype.newbyteorder("=") == np.float32 for column in columns) else np.float64
    return np.stack(columns, axis=1).astype(kind, copy=False)


def _list_of_faces(source: Source, header: Header) -> str:
    """The name of the property that lists the corners of a face."""
    vertex, face = (_only(source, header, name) for name in ("vertex", "face"))
    for axis in _AXES:
        if not any(known.name == axis and not known.length for known in vertex.properties):
            raise source.error(f"vertices have no property {axis!r}", remedy="they need numbers x, y and z")
    lists = [known for known in face.properties if known.length]
    named = [known for known in lists if known.name in _INDICES] or lists
    if not named:
        raise source.error("faces have no list of vertex indices", remedy="add property list uchar int vertex_indices")
    return _integer(source, named[0]).name


def _integer(source: Source, known: Property) -> Property:
    if known.type.startswith("f"):
        raise source.error(f"the indices {known.name!r} are of type float", remedy="indices are integers")
    return known


def _only(source: Source, header: Header, name: str) -> Element:
    found = [element for element in header.elements if element.name == name]
    if len(found) != 1:
        raise _number_of(source, name, len(found))
    names = [known.name for known in found[0].properties]
    twice = next((other for other in names if names.count(other) > 1), None)
    if twice is not None:
        raise source.error(f"the element {name!r} has the property {twice!r} twice", remedy="repair the header")
    return found[0]


def _number_of(source: Source, name: str, count: int) -> MeshError:
    if not count and name == "face":
        return source.error("has no element 'face'", remedy="export a mesh of triangles, not a cloud of points")
    return source.error(f"has {count} elements {name!r}", remedy="one is needed")
