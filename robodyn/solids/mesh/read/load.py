"""Meshes from files, standard input, bytes and arrays, of the type that is said or that they begin as."""

from __future__ import annotations

import os
import re

import numpy as np
from numpy.typing import ArrayLike

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.source import Source, open_source, scale_of
from robodyn.solids.mesh.read.stl import is_complete, open_binary
from robodyn.solids.mesh.triangles import MemoryTriangles, Triangles, check_finite
from robodyn.support.input_file import LFS_POINTER

_HEAD = 4096
_CONTROLS = bytes(set(range(32)) - set(b"\t\n\v\f\r"))
SCENES = ("dae", "glb", "gltf", "3mf")
"""Types that trimesh reads."""
KINDS = ("stl", "obj", "ply", "off", *SCENES)
"""All types of meshes; also the suffixes of their names."""
_OFF = rb"\s*(ST)?C?N?OFF\s"
_OBJ = rb"(?m)^v[ \t]+[-+.\d]"


def load_triangles(
    source: str | os.PathLike[str] | bytes,
    *,
    file_type: str | None = None,
    unit: str | None = None,
    typed: bool = False,
) -> Triangles:
    """Return the triangles of a mesh.

    Binary STL is streamed from the file. OBJ, PLY, OFF and ASCII STL are read here, all others by trimesh. Polygons are
    cut into triangles; nothing is merged, repaired or moved.

    Args:
        source: name of a file; `-` is standard input; or the bytes themselves.
        file_type: one of KINDS; by the suffix, or by how the file begins, if None.
        unit: "m", "mm", "cm" or "in"; what the file says if None, metres if it says nothing.
        typed: the user gave this very name, which may be that of a pipe then; see `open_input`.
    """
    found = open_source(source, typed)
    if found.data(len(LFS_POINTER)) == LFS_POINTER:
        raise found.error("is a pointer of Git LFS, not the mesh", remedy="git lfs pull fetches the mesh")
    kind = kind_of(found, file_type)
    if kind in SCENES:
        from robodyn.solids.mesh.read.scenes import read_scene

        return read_scene(found, kind, unit)
    scale, note = scale_of(unit, None, found.name)
    if kind == "stl":
        return _read_stl(found, scale, (note,))
    if kind == "ply":
        from robodyn.solids.mesh.read.ply import read_ply

        return read_ply(found, scale, (note,))
    if b"\0" in found.data(_HEAD):
        raise found.error(f"is binary data, no {kind.upper()}", remedy="is its type another?")
    from robodyn.solids.mesh.read.text import read_obj, read_off

    return (read_obj if kind == "obj" else read_off)(found, scale, (note,))


def from_array(corners: ArrayLike, *, name: str = "<array>", unit: str = "m") -> MemoryTriangles:
    """Return the triangles of an array (m, 3, 3); float32 counts as rounded to 24 bits, all else as exact."""
    try:
        given = np.asarray(corners)
        values = given if given.dtype == np.float32 else given.astype(np.float64, casting="same_kind")
    except (TypeError, ValueError):
        raise MeshError("the corners are not numbers", remedy="give an array (m, 3, 3)", file=name) from None
    if values.ndim != 3 or values.shape[1:] != (3, 3) or not len(values):
        what = f"an array of shape {values.shape} where (m, 3, 3) is needed"
        raise MeshError(what, remedy="axes are triangle, corner, coordinate", file=name)
    check_finite(values, 0, name)
    scale, _ = scale_of(unit, None, name)
    return MemoryTriangles(name, values, significand=24 if values.dtype == np.float32 else 53, scale=scale)


def _read_stl(source: Source, scale: float, notes: tuple[str, ...]) -> Triangles:
    """Binary if the size says so, even where the header begins with `solid`, or if there are bytes that no text has."""
    head = source.data(_HEAD)
    if is_complete(head, source.size) or head.translate(None, _CONTROLS) != head:
        return open_binary(source, head, scale, notes)
    if b"solid" not in head.lower() and b"facet" not in head.lower():
        raise source.error("is text without 'solid' or 'facet', no STL", remedy="is its type another?")
    from robodyn.solids.mesh.read.text import read_stl_text

    return read_stl_text(source, scale, notes)


def kind_of(source: Source, file_type: str | None) -> str:
    """One of KINDS: what the caller says, or the suffix if the file does not begin as another, or how it begins."""
    head = source.data(_HEAD)
    if file_type is not None:
        kind = file_type.lower().removeprefix(".")
        if kind not in KINDS:
            raise source.error(f"unknown type of mesh {file_type!r}", remedy=f"types: {', '.join(KINDS)}")
        return kind
    suffix = os.path.splitext(source.path or "")[1].lower().removeprefix(".")
    found = _begins_as(head, source.size)
    if suffix in KINDS:
        if found and found != suffix:
            raise source.error(
                f"is named .{suffix} but begins as {found.upper()} does", remedy=f"rename it to .{found}"
            )
        return suffix
    if suffix:
        raise source.error(f"unknown type of mesh .{suffix}", remedy=f"types: {', '.join(KINDS)}")
    if found is None:
        raise source.error("the type of mesh is not known", remedy=f"say which: {', '.join(KINDS)}")
    return found


def _begins_as(head: bytes, size: int) -> str | None:
    if is_complete(head, size):
        return "stl"
    text = head.lstrip().lower()
    signs = {
        "stl": text.startswith(b"solid") and b"facet" in text,
        "ply": head.startswith((b"ply\n", b"ply\r")),
        "glb": head.startswith(b"glTF"),
        "off": re.match(_OFF, re.sub(rb"#[^\r\n]*", b"", head)) is not None,
        "dae": b"<COLLADA" in head,
        "obj": b"\0" not in head and re.search(_OBJ, head) is not None,
    }
    return next((kind for kind, found in signs.items() if found), None)
