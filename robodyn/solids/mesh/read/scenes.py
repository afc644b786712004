"""Formats that hold scenes, through trimesh's loaders: every instance of a geometry in its place, nothing merged."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO
from typing import Any
from urllib.parse import unquote

import numpy as np

from robodyn.errors import InputError, MeshError
from robodyn.programs.vectors import product
from robodyn.solids.mesh.read.assets import asset_of
from robodyn.solids.mesh.read.source import Source, reading, scale_of
from robodyn.solids.mesh.triangles import Corners, IndexedTriangles, Indices, polygon_triangles
from robodyn.support.floats import Floats
from robodyn.support.input_file import read_input
from robodyn.support.input_limits import beyond, limits
from robodyn.support.libraries import library_messages, treated_warnings

_FLOAT32 = ("dae", "glb", "gltf")
"""Kinds whose coordinates are float32, in the file or in their reader."""

_Part = tuple[Corners, Indices]


def read_scene(source: Source, kind: str, unit: str | None) -> IndexedTriangles:
    """Return all triangles of a scene of one of `load.SCENES`, in its own axes; unit: see `scale_of`."""
    with _library_errors(source, kind):
        asset = asset_of(source, kind)
        scale, note = scale_of(unit, asset.metres, source.name)
        loaded, logged = _loaded(source, kind, asset.data)
        parts, faces, most = list[_Part](), 0, limits().mesh_faces
        for part in _placed(loaded):
            parts.append(part)
            faces += len(part[1])
            if faces > most:
                raise beyond("mesh_faces", f"{faces} triangles", MeshError, file=source.name)
    notes = [note, *asset.notes, *logged]
    if len(parts) > 1:
        notes.append(f"{len(parts)} geometries of the scene are taken together")
    firsts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    shifted = [indices + first for (_, indices), first in zip(parts, firsts[:-1], strict=True)]
    corners = np.concatenate([np.empty((0, 3), np.int64), *shifted])
    return polygon_triangles(
        source.name,
        np.concatenate([vertices for vertices, _ in parts]) if parts else np.empty((0, 3)),
        corners.reshape(-1),
        np.full(len(corners), 3),
        significand=24 if kind in _FLOAT32 else 53,
        scale=scale,
        notes=tuple(notes),
    )


def _loaded(source: Source, kind: str, data: bytes | None) -> tuple[dict[str, Any], list[str]]:
    """Return the arguments with which trimesh would make a scene, and what its loader had to say.

    `trimesh.load` itself merges vertices and drops those that are not finite, whatever it is asked.
    """
    from trimesh.exchange.load import mesh_loaders

    resolver = _Beside(source) if source.path and kind == "gltf" else None
    options: dict[str, Any] = {"file_type": kind, "resolver": resolver}
    if kind in ("glb", "gltf"):
        options["skip_materials"] = True
    if kind == "dae":
        options["ignore_broken"] = False
    loader: Any = mesh_loaders[kind]
    unread = treated_warnings("error", "string or file could not be read to its end")
    with source.opened() as stream, library_messages("trimesh") as messages, unread, np.errstate(all="ignore"):
        loaded: dict[str, Any] = loader(file_obj=stream if data is None else BytesIO(data), **options)
    lines = [message.partition("\n")[0] for message in messages]
    harmless = ("texture", "shininess")
    return loaded, [f"trimesh: {x[:200]}" for x in lines if not any(word in x.lower() for word in harmless)]


class _Beside:
    """Files that a glTF names, if they are in its own folder; trimesh opens none by itself."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._folder = os.path.dirname(source.path or "")
        self._homes = {os.path.realpath(self._folder), os.path.dirname(os.path.realpath(source.path or ""))}

    def get(self, name: str) -> bytes:
        """Return the bytes of a regular file in the folder."""
        given = os.path.join(self._folder, name)
        path = os.path.realpath(given if os.path.lexists(given) else os.path.join(self._folder, unquote(name)))
        if not any(os.path.commonpath([home, path]) == home for home in self._homes):
            what = f"names {name[:80]!r}, a file outside of its folder"
            raise self._source.error(what, remedy="put it beside the mesh")
        with reading(path):
            return read_input(path)

    __getitem__ = get


def _placed(loaded: Mapping[str, Any]) -> Iterator[_Part]:
    """Vertices and faces of each instance of each geometry that has faces.

    `trimesh.Scene` itself would change transforms a little: nearly rigid ones into rigid ones.
    """
    geometries, edges = loaded.get("geometry"), loaded.get("graph")
    if geometries is None or edges is None:
        for geometry in [loaded] if geometries is None else geometries.values():
            yield from _moved(geometry, np.eye(4))
        return
    base = loaded.get("base_frame", "world")
    above = {edge["frame_to"]: edge for edge in edges}
    for edge in edges:
        if edge.get("geometry") is not None:
            yield from _moved(geometries[edge["geometry"]], _to_base(edge, above, base))


def _to_base(edge: Mapping[str, Any], above: Mapping[Any, Mapping[str, Any]], base: Any) -> Floats:
    """The transform (4, 4) from the end of an edge of the scene's graph to its base; `above`: edges by their ends."""
    matrix: Floats = np.eye(4)
    for _ in range(len(above) + 1):
        matrix = product(np.asarray(edge.get("matrix", np.eye(4)), dtype=np.float64), matrix)
        parent = edge.get("frame_from", base)
        if parent == base:
            return matrix
        if parent not in above:
            break
        edge = above[parent]
    raise ValueError("a geometry hangs on a node that is not part of the scene")


def _moved(geometry: Mapping[str, Any], matrix: Floats) -> Iterator[_Part]:
    """The geometry where the matrix (4, 4) puts it, if it has faces; a mirror image keeps its outside outside.

    Every vertex is moved by the same operations, so that equal vertices stay equal to the last bit.
    """
    faces = geometry.get("faces")
    if faces is None or not len(faces):
        return
    vertices = np.asarray(geometry["vertices"])
    corners = np.asarray(faces).astype(np.int64)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or corners.ndim != 2 or corners.shape[1] != 3:
        raise ValueError(f"vertices of shape {vertices.shape}, faces of shape {corners.shape}")
    if vertices.dtype not in (np.float32, np.float64):
        vertices = vertices.astype(np.float64)
    if not (np.isfinite(matrix).all() and np.array_equal(matrix[3], (0, 0, 0, 1))):
        raise ValueError("a transform of the scene is not affine")
    if not ((corners >= 0) & (corners < len(vertices))).all():
        raise ValueError(f"a face names a vertex that is not among the {len(vertices)} of its geometry")
    if not np.array_equal(matrix, np.eye(4)):
        x, y, z = vertices.astype(np.float64).T
        vertices = np.stack([row[0] * x + row[1] * y + row[2] * z + row[3] for row in matrix[:3]], axis=1)
        if np.linalg.det(matrix[:3, :3]) < 0:
            corners = corners[:, ::-1]
    yield vertices, corners


@contextmanager
def _library_errors(source: Source, kind: str) -> Iterator[None]:
    """Tells whatever a library raises about a damaged file as a MeshError."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        line = str(error).strip().partition("\n")[0]
        if not line or isinstance(error, KeyError):
            line = f"{type(error).__name__} {line}".strip()
        what = f"cannot be read as {kind.upper()}: {line[:200]}"
        raise source.error(what, remedy="export it again, or as STL, OBJ or PLY") from None
