"""Scenes: what a file says about itself and must not hold, then its geometry, each instance, by trimesh's loaders."""

from __future__ import annotations

import json
import math
import os
import zipfile
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from typing import Any, BinaryIO
from urllib.parse import unquote
from xml.etree import ElementTree
from xml.etree.ElementTree import Element
from xml.parsers import expat

import numpy as np

from robodyn.errors import InputError, MeshError
from robodyn.programs.vectors import product
from robodyn.solids.mesh.read.source import Source, reading, scale_of
from robodyn.solids.mesh.triangles import Corners, Indices, MemoryTriangles, polygon_triangles
from robodyn.support.floats import Floats
from robodyn.support.input_file import beyond, limits, read_input
from robodyn.support.libraries import library_messages, treated_warnings

_LOOKS = (
    "bind_material",
    "instance_light",
    "instance_camera",
    *(f"library_{name}" for name in ("materials", "effects", "images", "lights", "cameras", "animations")),
)
"""Elements without which a scene has the same shape. A reference that is broken in one of them hides geometry."""
_UNITS_3MF = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 0.0254, "foot": 0.3048, "meter": 1.0}
_LARGEST_ELEMENT = 16
"""Bytes of an element of an accessor, but for matrices, which no mesh has."""
_HARMLESS = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_", "MSFT_texture_", "KHR_xmp")
_FLOAT32 = ("dae", "glb", "gltf")
"""Kinds whose coordinates are float32, in the file or in their reader."""

_OF_INDICES = frozenset("0123456789 \t\r\n")

_Part = tuple[Corners, Indices]


@dataclass(frozen=True)
class Asset:
    """Metres per unit of the file, None if it says none; what else to note; what to read in place of the file."""

    metres: float | None
    notes: tuple[str, ...] = ()
    data: bytes | None = None


def _dae(source: Source, stream: BinaryIO) -> Asset:
    """Return what a COLLADA says, and the document without its looks. Refuses positions that are not finite and
    negative indices, which pycollada would read as 0 and from the end."""
    root = ElementTree.parse(stream).getroot()
    for polygons in root.iterfind(".//{*}polygons"):
        _join(polygons)
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
    positions = {
        place.get("source", "").removeprefix("#")
        for place in root.iterfind(".//{*}vertices/{*}input")
        if place.get("semantic") == "POSITION"
    }
    for known in root.iterfind(".//{*}source"):
        name, text = known.get("id", ""), known.findtext("{*}float_array") or ""
        if name not in positions or "n" not in text.lower():
            continue
        for at, word in enumerate(text.split()):
            if not math.isfinite(float(word)):
                what = f"vertex {at // 3 + 1} of {name!r} has the coordinate {word}"
                raise source.error(what, remedy="coordinates must be finite")
    _count_collada(source, root)
    if any("-" in (indices.text or "") for indices in root.iterfind(".//{*}p")):
        raise source.error("an index is negative", remedy="the file is damaged: export it again")
    for parent in list(root.iter()):
        for child in list(parent):
            if _tag(child) in _LOOKS:
                parent.remove(child)
    notes = (f"the axis {up[0]} points up in the file; its axes are kept",) if up in ("X_UP", "Y_UP") else ()
    return Asset(metres, notes, ElementTree.tostring(root, "utf-8"))


def _join(polygons: Element) -> None:
    """Make one list of indices of many, as pycollada reads each by itself: of whole corners, without holes."""
    inputs, lists = polygons.findall("{*}input"), polygons.findall("{*}p")
    offsets = [each.get("offset", "") for each in inputs]
    texts = [each.text or "" for each in lists]
    counts = [len(text.split()) for text in texts]
    plain = inputs and lists and len(inputs) + len(lists) == len(polygons) and all(map(str.isdecimal, offsets))
    if not plain or not all(counts) or not set().union(*texts) <= _OF_INDICES:
        return
    width = 1 + max(map(int, offsets))
    if any(count % width for count in counts):
        return
    space = polygons.tag.removesuffix("polygons")
    polygons[:] = inputs
    polygons.tag = f"{space}polylist"
    ElementTree.SubElement(polygons, f"{space}vcount").text = " ".join(str(count // width) for count in counts)
    ElementTree.SubElement(polygons, f"{space}p").text = " ".join(texts)


def _tag(element: Element) -> str:
    return element.tag.rpartition("}")[2] if isinstance(element.tag, str) else ""


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
    # nodes that are not trees, each of which trimesh would read once, and too many of them
    uses = {str(k): list(map(str, node.get("children", []))) for k, node in enumerate(header.get("nodes", []))}
    children = Counter(child for each in uses.values() for child in each)
    if children.total() > len(children):
        what = "a node is the child of two nodes, or twice of one"
        raise source.error(what, remedy="nodes of glTF are trees: export it again")
    _count(source, uses, [name for name in uses if name not in children], "mesh_nodes", "nodes")
    size = 0
    for accessor in header.get("accessors", []):
        if "bufferView" not in accessor:
            raise source.error("holds an accessor without a buffer", remedy="export it without sparse accessors")
        if not 0 <= accessor["count"] < 1 << 32:
            raise source.error(f"an accessor of {accessor['count']} elements", remedy="export it again")
        size += accessor["count"] * _LARGEST_ELEMENT
    if size > max(limits().mesh_unpacked, _LARGEST_ELEMENT * source.size):
        raise beyond("mesh_unpacked", f"its accessors stand for up to {size} bytes", MeshError, file=source.name)
    return Asset(1.0, ("the axis Y points up in glTF; its axes are kept",))


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
    """Refuse a scene with too many nodes, each counted as often as it is used, or with nodes too deep in one another;
    uses: by its name, the names of those in each node; limit: name of that of their number."""
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


def read_scene(source: Source, kind: str, unit: str | None) -> MemoryTriangles:
    """Return all triangles of a scene of one of `load.SCENES`, in its own axes; unit: see `scale_of`."""
    with _library_errors(source, kind):
        with source.opened() as stream:  # what the file says about its unit and axes; what would be read wrongly
            if kind == "gltf":
                asset = _gltf_of(source, json.load(stream))
            else:
                asset = {"dae": _dae, "3mf": _3mf, "glb": _glb}[kind](source, stream)
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
    """Return the arguments with which trimesh would make a scene, and what its loader had to say. `trimesh.load` itself
    merges vertices and drops those that are not finite, whatever it is asked."""
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
    """Vertices and faces of each instance of each geometry that has faces. `trimesh.Scene` itself would change
    transforms a little: nearly rigid ones into rigid ones."""
    geometries, edges = loaded.get("geometry"), loaded.get("graph")
    if geometries is None or edges is None:
        for geometry in [loaded] if geometries is None else geometries.values():
            yield from _moved(geometry, np.eye(4))
        return
    base = loaded.get("base_frame", "world")
    above = {edge["frame_to"]: edge for edge in edges}
    for instance in edges:
        if instance.get("geometry") is None:
            continue
        matrix, edge, parent = np.eye(4), instance, None
        for _ in range(len(above) + 1):
            matrix = product(np.asarray(edge.get("matrix", np.eye(4)), dtype=np.float64), matrix)
            parent = edge.get("frame_from", base)
            if parent == base or parent not in above:
                break
            edge = above[parent]
        if parent != base:
            raise ValueError("a geometry hangs on a node that is not part of the scene")
        yield from _moved(geometries[instance["geometry"]], matrix)


def _moved(geometry: Mapping[str, Any], matrix: Floats) -> Iterator[_Part]:
    """The geometry where the matrix (4, 4) puts it, if it has faces; a mirror image keeps its outside outside. Every
    vertex is moved by the same operations, so that equal vertices stay equal to the last bit."""
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
