"""PLY, ASCII and binary: the elements `vertex` and `face`; others are passed over."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.solids.mesh.read.lines import Integers, Tokens, chunks, runs
from robodyn.solids.mesh.read.ply_binary import Columns, read_binary
from robodyn.solids.mesh.read.ply_header import Element, Header, read_header
from robodyn.solids.mesh.read.polygons import triangles_of
from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.triangles import Corners, IndexedTriangles


def read_text(source: Source, header: Header, wanted: Mapping[str, Sequence[str]]) -> Columns:
    """Return the wanted properties; see `read_binary`.

    Raises:
        MeshError: a line has not as many words as its properties need, a word is no number, or lines are missing.
    """
    parts: dict[tuple[str, str], list[tuple[Integers, NDArray[Any]]]] = {}
    for element in header.elements:
        parts.update({(element.name, name): [] for name in wanted.get(element.name, ())})
    waiting = [element for element in header.elements if element.count and element.properties]
    read = 0
    for words in chunks(source, header.size):
        line = 0
        while waiting and line < len(words.first) - 1:
            element = waiting[0]
            rows = slice(line, min(line + element.count - read, len(words.first) - 1))
            for name, column in _rows(words, element, rows, wanted.get(element.name, ())).items():
                parts[element.name, name].append(column)
            read += rows.stop - rows.start
            line = rows.stop
            if read == element.count:
                waiting, read = waiting[1:], 0
    if waiting:
        what = f"the header promises {waiting[0].count} of the element {waiting[0].name!r}, {read} are there"
        raise source.error(what, remedy="the file is cut short: get it again")
    return {key: _joined(columns) for key, columns in parts.items()}


def _joined(columns: list[tuple[Integers, NDArray[Any]]]) -> tuple[Integers, NDArray[Any]]:
    if not columns:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    return np.concatenate([sizes for sizes, _ in columns]), np.concatenate([values for _, values in columns])


def _rows(
    words: Tokens, element: Element, rows: slice, wanted: Sequence[str]
) -> dict[str, tuple[Integers, NDArray[Any]]]:
    """Return the wanted properties of some lines."""
    if not wanted:
        return {}
    at, end = words.first[rows], words.first[rows.start + 1 : rows.stop + 1]
    found = {}
    for known in element.properties:
        sizes = np.ones(len(at), np.int64)
        _check_within(words, element, at, end)
        if known.length:
            sizes = words.integers(at)
            _check_within(words, element, at + np.maximum(sizes, 0), end, sizes < 0)
            at = at + 1
        if known.name in wanted:
            index = at
            if known.length:
                index = runs(at, sizes)
            found[known.name] = sizes, _values(words, index, known.type)
        at = at + sizes
    _check_within(words, element, at - 1, end, at != end)
    return found


def _values(words: Tokens, index: Integers, kind: str) -> NDArray[Any]:
    if not kind.startswith("f"):
        return words.integers(index)
    with np.errstate(over="ignore"):
        return words.floats(index).astype(kind)


def _check_within(
    words: Tokens, element: Element, at: Integers, end: Integers, wrong: NDArray[Any] | bool = False
) -> None:
    """That the words `at` stand before the words `end`, the first ones of the next lines."""
    what = f"the line has not the number of words that an element {element.name!r} needs"
    words.refuse((at >= end) | wrong, end - 1, what, "one line holds all properties of one element")


_AXES = ("x", "y", "z")
_INDICES = ("vertex_indices", "vertex_index")


def read_ply(source: Source, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
    """Return the faces of a PLY, with coordinates of the type that the header names.

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
    """Return the name of the property that lists the corners of a face."""
    vertex, face = (_only(source, header, name) for name in ("vertex", "face"))
    for axis in _AXES:
        if not any(known.name == axis and not known.length for known in vertex.properties):
            raise source.error(f"vertices have no property {axis!r}", remedy="they need numbers x, y and z")
    lists = [known for known in face.properties if known.length]
    named = [known for known in lists if known.name in _INDICES] or lists
    if not named:
        raise source.error("faces have no list of vertex indices", remedy="add property list uchar int vertex_indices")
    if named[0].type.startswith("f"):
        raise source.error(f"the indices {named[0].name!r} are of type float", remedy="indices are integers")
    return named[0].name


def _only(source: Source, header: Header, name: str) -> Element:
    found = [element for element in header.elements if element.name == name]
    if not found and name == "face":
        raise source.error("has no element 'face'", remedy="export a mesh of triangles, not a cloud of points")
    if len(found) != 1:
        raise source.error(f"has {len(found)} elements {name!r}", remedy="one is needed")
    names = [known.name for known in found[0].properties]
    often = Counter(names)
    twice = next((other for other in names if often[other] > 1), None)
    if twice is not None:
        raise source.error(f"the element {name!r} has the property {twice!r} twice", remedy="repair the header")
    return found[0]
