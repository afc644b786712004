"""Meshes from files, standard input, bytes and arrays, of the type that is said or that they begin as; and binary STL,
streamed: 80 bytes of header, the number of triangles, then 50 bytes for each of them."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.source import Source, open_source, scale_of
from robodyn.solids.mesh.triangles import BLOCK, Corners, MemoryTriangles, Triangles, check_finite, checked
from robodyn.support.input_file import LFS_POINTER

_HEAD = 4096
_CONTROLS = bytes(set(range(32)) - set(b"\t\n\v\f\r"))
SCENES = ("dae", "glb", "gltf", "3mf")
"""Types that trimesh reads."""
KINDS = ("stl", "obj", "ply", "off", *SCENES)
"""All types of meshes; also the suffixes of their names."""
_OFF = rb"\s*(ST)?C?N?OFF\s"
_OBJ = rb"(?m)^v[ \t]+[-+.\d]"
_START, _RECORD = 84, 50
_TYPE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


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
        source: name of a file, `-` for standard input, or the bytes themselves.
        file_type: one of KINDS; by the suffix, or by how the file begins, if None.
        unit: a key of METRES; what the file says if None, metres if it says nothing.
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
    if kind == "stl":  # binary if the size says so, even after `solid`, or if there are bytes that no text has
        head = found.data(_HEAD)
        if _is_binary_stl(head, found.size) or head.translate(None, _CONTROLS) != head:
            return _binary_stl(found, head, scale, (note,))
        if b"solid" not in head.lower() and b"facet" not in head.lower():
            raise found.error("is text without 'solid' or 'facet', no STL", remedy="is its type another?")
        from robodyn.solids.mesh.read.text import read_stl_text

        return read_stl_text(found, scale, (note,))
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


def kind_of(source: Source, file_type: str | None) -> str:
    """One of KINDS: what the caller says, or the suffix if the file does not begin as another, or how it begins."""
    head = source.data(_HEAD)
    if file_type is not None:
        kind = file_type.lower().removeprefix(".")
        if kind not in KINDS:
            raise source.error(f"unknown type of mesh {file_type!r}", remedy=f"types: {', '.join(KINDS)}")
        return kind
    suffix = os.path.splitext(source.path or "")[1].lower().removeprefix(".")
    text = head.lstrip().lower()
    signs = {
        "stl": _is_binary_stl(head, source.size) or (text.startswith(b"solid") and b"facet" in text),
        "ply": head.startswith((b"ply\n", b"ply\r")),
        "glb": head.startswith(b"glTF"),
        "off": re.match(_OFF, re.sub(rb"#[^\r\n]*", b"", head)) is not None,
        "dae": b"<COLLADA" in head,
        "obj": b"\0" not in head and re.search(_OBJ, head) is not None,
    }
    found = next((kind for kind, is_it in signs.items() if is_it), None)
    if suffix in KINDS:
        if found and found != suffix:
            what = f"is named .{suffix} but begins as {found.upper()} does"
            raise source.error(what, remedy=f"rename it to .{found}")
        return suffix
    if suffix:
        raise source.error(f"unknown type of mesh .{suffix}", remedy=f"types: {', '.join(KINDS)}")
    if found is None:
        raise source.error("the type of mesh is not known", remedy=f"say which: {', '.join(KINDS)}")
    return found


def _is_binary_stl(head: bytes, size: int) -> bool:
    """Return whether a file of this size that begins so is exactly a binary STL, whatever the text in its header."""
    return len(head) >= _START and size == _START + _RECORD * int.from_bytes(head[80:_START], "little")


@dataclass(frozen=True, eq=False)
class StlTriangles(Triangles):
    """Triangles of a binary STL, read anew, a block at a time, whenever they are asked for. The coordinates of a block
    are contiguous: `block.transpose(1, 2, 0)` is in C order."""

    source: Source
    promised: int

    @property
    def count(self) -> int:
        return self.promised

    def blocks(self, rows: int = BLOCK) -> Iterator[Corners]:
        def columns(corners: Corners) -> Corners:
            found = np.empty((3, 3, len(corners)), np.float32)
            found[...] = corners.transpose(1, 2, 0)
            return found.transpose(2, 0, 1)

        return checked(map(columns, self.records(rows)), self.name)

    def records(self, rows: int = BLOCK) -> Iterator[Corners]:
        held = self.source.memory()
        if held is not None:
            corners = np.frombuffer(held, _TYPE, self.count, _START)["corners"]
            yield from (corners[first : first + rows] for first in range(0, self.count, rows))
            return
        data = bytearray(_RECORD * min(rows, self.count))
        with self.source.opened() as stream:
            for first in range(0, self.count, rows):
                wanted = _RECORD * min(rows, self.count - first)
                stream.seek(_START + _RECORD * first)
                if stream.readinto(memoryview(data)[:wanted]) != wanted:  # type: ignore[attr-defined]
                    raise self.source.error("was cut short while it was read", remedy="run again")
                yield np.frombuffer(data, _TYPE, wanted // _RECORD)["corners"]


def _binary_stl(source: Source, head: bytes, scale: float, notes: tuple[str, ...]) -> StlTriangles:
    if len(head) < _START:
        what = f"{source.size} bytes are no STL, whose header alone has {_START}"
        raise source.error(what, remedy="export the mesh again")
    count, there = int.from_bytes(head[80:_START], "little"), (source.size - _START) // _RECORD
    if count > there:
        what = f"the header promises {count} triangles ({_START + _RECORD * count} bytes), the file has"
        what += f" {source.size} bytes, {there} whole triangles"
        raise source.error(what, remedy="it is cut short or no STL: get it again")
    if not count:
        though = f", though {source.size - _START} bytes follow" if source.size > _START else ""
        raise source.error(f"the header promises 0 triangles{though}", remedy="export the mesh again")
    extra = source.size - _START - _RECORD * count
    warnings: tuple[str, ...] = ()
    if extra >= _RECORD:
        left_out = f"the file has room for {there}: {there - count} are left out"
        warnings = (f"the header counts {count} triangles, {left_out}",)
    elif extra:
        notes = (*notes, f"{extra} bytes after the last triangle are left out")
    labels: dict[str, Any] = {"significand": 24, "scale": scale, "notes": notes, "warnings": warnings}
    return StlTriangles(source.name, source, count, **labels)
