"""Of which type and in which unit a mesh is: as asked, by what the file says, or by how it begins."""

from __future__ import annotations

import os
import re

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.read.stl_binary import is_complete

METRES = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254}
"""Metres per unit, by the names that `unit` may have."""


def scale_of(unit: str | None, own: float | None, name: str) -> tuple[float, str]:
    """Metres per unit of the file, and the note about it.

    Args:
        unit: what the caller says, a key of METRES; it counts more than what the file says.
        own: metres per unit as the file says; None if it does not.

    Raises:
        MeshError: there is no such unit.
    """
    if unit is not None and unit not in METRES:
        raise MeshError(f"unknown unit {unit!r}", remedy=f"units: {', '.join(METRES)}", file=name)
    if unit is None:
        return (
            (1.0, "unit: metres, as the file says none") if own is None else (own, f"unit: {_named(own)} by the file")
        )
    given = METRES[unit]
    contrary = own is not None and abs(own - given) > 1e-9 * given
    return given, f"unit: {unit} as asked" + (f", though the file says {_named(own or 0.0)}" if contrary else "")


def _named(metres: float) -> str:
    return next((name for name, value in METRES.items() if value == metres), f"{metres:g} m")


SCENES = ("dae", "zae", "glb", "gltf", "3mf", "3dxml", "xaml")
"""Types that trimesh reads."""
KINDS = ("stl", "obj", "ply", "off", *SCENES)
"""All types of meshes; also the suffixes of their names."""
_HEAD = 4096
_OFF = rb"\s*(ST)?C?N?OFF\s"
_OBJ = rb"(?m)^v[ \t]+[-+.\d]"


def kind_of(source: Source, file_type: str | None) -> str:
    """One of KINDS.

    Args:
        file_type: what the caller says, one of them.

    Raises:
        MeshError: there is no such type, the suffix is unknown, or the file begins as one of another type.
    """
    head = source.data(_HEAD)
    if file_type is not None:
        kind = file_type.lower().removeprefix(".")
        if kind not in KINDS:
            raise source.error(f"unknown type of mesh {file_type!r}", remedy=f"types: {', '.join(KINDS)}")
        return kind
    suffix = os.path.splitext(source.path or "")[1].lower().removeprefix(".")
    found = _begins_as(head, source.size)
    if suffix in KINDS:
        if found and found != suffix and {found, suffix} != {"dae", "xaml"}:
            raise source.error(
                f"is named .{suffix} but begins as {found.upper()} does", remedy=f"say its type: {found}"
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
