"""What a scene file says about itself, and what it must not hold, before trimesh reads its geometry."""

from __future__ import annotations

import json
import math
import zipfile
from collections import Counter
from dataclasses import dataclass
from typing import Any, BinaryIO
from xml.etree import ElementTree
from xml.etree.ElementTree import Element
from xml.parsers import expat

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.source import Source
from robodyn.support.input_limits import beyond, limits

_LOOKS = (
    "bind_material",
    "instance_light",
    "instance_camera",
    *(f"library_{name}" for name in ("materials", "effects", "images", "lights", "cameras", "animations")),
)
"""Elements without which a scene has the same shape. A reference that is broken in one of them hides geometry."""


@dataclass(frozen=True)
class Asset:
    """Metres per unit of the file, None if it says none; what else to note; what to read in place of the file."""

    metres: float | None
    notes: tuple[str, ...] = ()
    data: bytes | None = None


def _dae(source: Source, stream: BinaryIO) -> Asset:
    """Return what a COLLADA says, and the document without its looks.

    Refuses positions that are not finite and negative indices, which pycollada would read as 0 and from the end.
    """
    root = ElementTree.parse(stream).getroot()
    asset = root.find("{*}asset")
    unit = None if asset is None else asset.find("{*}unit")
    metres = None
    if unit is not None and "meter" in unit.attrib:
        text = unit.attrib["meter"]
        try:
            metres = float(text)
        except ValueError:
            metres = math.nan
        if not 0 < metres < math.inf:
            raise source.error(f"the unit {text[:40]!r} is not a length in metres", remedy="repair <unit meter>")
    up = "" if asset is None else (asset.findtext("{*}up_axis") or "").strip()
    _check_positions(source, root)
    _count_collada(source, root)
    if any("-" in (indices.text or "") for indices in root.iterfind(".//{*}p")):
        raise source.error("an index is negative", remedy="the file is damaged: export it again")
    for parent in list(root.iter()):
        for child in list(parent):
            if _tag(child) in _LOOKS:
                parent.remove(child)
    notes = (f"the axis {up[0]} points up in the file; its axes are kept",) if up in ("X_UP", "Y_UP") else ()
    return Asset(metres, notes, ElementTree.tostring(root, "utf-8"))


def _tag(element: Element) -> str:
    return element.tag.rpartition("}")[2] if isinstance(element.tag, str) else ""


def _check_positions(source: Source, root: Element) -> None:
    used = {
        place.get("source", "").removeprefix("#")
        for place in root.iterfind(".//{*}vertices/{*}input")
        if place.get("semantic") == "POSITION"
    }
    for known in root.iterfind(".//{*}source"):
        name, text = known.get("id", ""), known.findtext("{*}float_array") or ""
        if name not in used or "n" not in text.lower():
            continue
        for at, word in enumerate(text.split()):
            if not math.isfinite(float(word)):
                what = f"vertex {at // 3 + 1} of {name!r} has the coordinate {word}"
                raise source.error(what, remedy="coordinates must be finite")


_UNITS_3MF = {
    "micron": 1e-6,
    "millimeter": 1e-3,
    "centimeter": 1e-2,
    "inch": 0.0254,
    "foot": 0.3048,
    "meter": 1.0,
}
_LARGEST_ELEMENT = 16
"""Bytes of an element of an accessor, but for matrices, which no mesh has."""
_HARMLESS = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_", "MSFT_texture_", "KHR_xmp")


def asset_of(source: Source, kind: str) -> Asset:
    """Return what a file of this kind says about its unit and axes; refuses what would be read wrongly."""
    with source.opened() as stream:
        if kind == "gltf":
            return _gltf_of(source, json.load(stream))
        return {"dae": _dae, "3mf": _3mf, "glb": _glb}[kind](source, stream)


def _3mf(source: Source, stream: BinaryIO) -> Asset:
    units, items, current = list[str](), list[str](), ""
    uses: dict[str, list[str]] = {}

    def begin(tag: str, attributes: dict[str, str]) -> None:
        nonlocal current
        name = tag.rpartition("}")[2]
        if name == "model":
            units.append(attributes.get("unit", "millimeter"))
        elif name == "object":
            current = attributes.get("id", "")
            uses[current] = []
        elif name == "component":
            uses.setdefault(current, []).append(attributes.get("objectid", ""))
        elif name == "item":
            items.append(attributes.get("objectid", ""))

    parser = expat.ParserCreate(namespace_separator="}")
    parser.StartElementHandler = begin
    with zipfile.ZipFile(stream) as archive:
        size = sum(info.file_size for info in archive.infolist())
        if size > limits().mesh_unpacked:
            raise beyond("mesh_unpacked", f"unpacks to {size} bytes", MeshError, file=source.name)
        name = next((name for name in archive.namelist() if "3d/3dmodel.model" in name.lower()), None)
        if name is None:
            raise source.error("has no 3D/3dmodel.model inside", remedy="export it again")
        with archive.open(name) as model:
            parser.ParseFile(model)
    _count(source, uses, items, "mesh_items", "objects")
    unit = units[0] if units else "millimeter"
    if unit not in _UNITS_3MF:
        raise source.error(f"unknown unit {unit[:40]!r}", remedy=f"units of 3MF: {', '.join(_UNITS_3MF)}")
    return Asset(_UNITS_3MF[unit])


def _glb(source: Source, stream: BinaryIO) -> Asset:
    head = stream.read(20)
    length, chunk = int.from_bytes(head[8:12], "little"), int.from_bytes(head[12:16], "little")
    if head[:4] != b"glTF" or head[16:] != b"JSON":
        raise source.error("does not begin as a GLB does", remedy="is its type another?")
    if length > source.size:
        what = f"the header promises {length} bytes, the file has {source.size}"
        raise source.error(what, remedy="the file is cut short: get it again")
    return _gltf_of(source, json.loads(stream.read(min(chunk, source.size))))


def _gltf_of(source: Source, header: Any) -> Asset:
    harmful = [name for name in header.get("extensionsRequired", []) if not str(name).startswith(_HARMLESS)]
    if harmful:
        what = f"needs the glTF extension {str(harmful[0])[:60]!r}, which is not read"
        raise source.error(what, remedy="export it without compression")
    _count_gltf(source, header.get("nodes", []))
    accessors, size = header.get("accessors", []), 0
    for accessor in accessors:
        if "bufferView" not in accessor:
            raise source.error("holds an accessor without a buffer", remedy="export it without sparse accessors")
        if not 0 <= accessor["count"] < 1 << 32:
            raise source.error(f"an accessor of {accessor['count']} elements", remedy="export it again")
        size += accessor["count"] * _LARGEST_ELEMENT
    if size > max(limits().mesh_unpacked, _LARGEST_ELEMENT * source.size):
        raise beyond("mesh_unpacked", f"its accessors stand for up to {size} bytes", MeshError, file=source.name)
    return Asset(1.0, ("the axis Y points up in glTF; its axes are kept",))


def _count_gltf(source: Source, nodes: list[dict[str, Any]]) -> None:
    """Refuse nodes that are not trees, as trimesh would read each of them once, and too many of them."""
    uses = {str(k): list(map(str, node.get("children", []))) for k, node in enumerate(nodes)}
    children = Counter(child for each in uses.values() for child in each)
    if children.total() > len(children):
        what = "a node is the child of two nodes, or twice of one"
        raise source.error(what, remedy="nodes of glTF are trees: export it again")
    _count(source, uses, [name for name in uses if name not in children], "mesh_nodes", "nodes")


def _count_collada(source: Source, root: Element) -> None:
    """Refuse nodes that are too many, each counted as often as others refer to it."""
    uses: dict[str, list[str]] = {}
    names = {each: f"#{each.get('id', '')}" for each in root.iter() if _tag(each) == "node" and each.get("id")}
    for k, each in enumerate(root.iter()):
        if _tag(each) == "node":
            names.setdefault(each, f"node {k}")
    for node, name in names.items():
        inner = [names[child] for child in node if child in names]
        uses[name] = inner + [each.get("url", "") for each in node if _tag(each) == "instance_node"]
    scenes = [names[node] for scene in root.iterfind(".//{*}visual_scene") for node in scene if node in names]
    _count(source, uses, scenes, "mesh_nodes", "nodes")


def _count(source: Source, uses: dict[str, list[str]], roots: list[str], limit: str, what: str) -> None:
    """Refuse a scene with too many nodes, each counted as often as it is used, or with nodes too deep in one another.

    Args:
        uses: by its name, the names of those in each node. limit: name of that of their number.
    """
    depth, most = limits().mesh_depth, getattr(limits(), limit)
    size: dict[str, int] = {}
    for root in dict.fromkeys(roots):
        path = [(root, iter(uses.get(root, ())))]
        while path:
            name, rest = path[-1]
            below = next((each for each in rest if each not in size), None)
            if below is None:
                size[name] = 1 + sum(size[each] for each in uses.get(name, ()))
                path.pop()
                continue
            path.append((below, iter(uses.get(below, ()))))
            if len(path) > depth:
                raise beyond("mesh_depth", f"{what} more than {depth} deep in one another", MeshError, file=source.name)
    total = max(sum(size[root] for root in roots), len(uses))
    if total > most:
        raise beyond(limit, f"{total} {what}", MeshError, file=source.name)
