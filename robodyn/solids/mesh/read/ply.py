"""PLY, text and binary: the elements `vertex` and `face`; others are passed over."""

from __future__ import annotations

from array import array
from collections import Counter
from dataclasses import dataclass
from itertools import islice
from struct import calcsize, error, unpack_from
from typing import Any, Literal, NamedTuple

import numpy as np

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.read.text import TRUNCATED, indices, lines, numbers
from robodyn.solids.mesh.triangles import Corners, MemoryTriangles, polygon_triangles

Encoding = Literal["ascii", "<", ">"]

_TYPES = {
    **dict.fromkeys(("char", "int8"), "b"),
    **dict.fromkeys(("uchar", "uint8"), "B"),
    **dict.fromkeys(("short", "int16"), "h"),
    **dict.fromkeys(("ushort", "uint16"), "H"),
    **dict.fromkeys(("int", "int32"), "i"),
    **dict.fromkeys(("uint", "uint32"), "I"),
    **dict.fromkeys(("int64", "longlong"), "q"),
    **dict.fromkeys(("uint64", "ulonglong"), "Q"),
    **dict.fromkeys(("float", "float32"), "f"),
    **dict.fromkeys(("double", "float64"), "d"),
}
"""Codes of `struct`, which are NumPy's as well."""
_ENCODINGS: dict[str, Encoding] = {"ascii": "ascii", "binary_little_endian": "<", "binary_big_endian": ">"}
_LONGEST = 1 << 20
_AXES = ("x", "y", "z")
_INDICES = ("vertex_indices", "vertex_index")
_WANTED = ("vertex", "face")
_Columns = dict[str, tuple[Any, Any]]
"""By property: lengths, 1 where it is no list, and all values, one row after the other."""


class Property(NamedTuple):
    """A number, or a list whose length is a number of type `length`; types as codes without byte order."""

    name: str
    type: str
    length: str | None


@dataclass(frozen=True)
class Element:
    name: str
    count: int
    properties: tuple[Property, ...]


class Header(NamedTuple):
    """What the first `size` bytes of a file, so many lines, say: the data begin there."""

    encoding: Encoding
    elements: tuple[Element, ...]
    size: int
    lines: int


def read_header(source: Source) -> Header:
    """Return the header of a PLY, which has to end within 1 MB."""

    def property_of(words: list[str]) -> Property:
        if words[1] == "list":
            _, _, length, kind, name = words
            if _TYPES[length] in "fd":
                raise ValueError(length)
            return Property(name, _TYPES[kind], _TYPES[length])
        _, kind, name = words
        return Property(name, _TYPES[kind], None)

    text = source.data(_LONGEST)
    if not text.startswith(b"ply"):
        raise source.error("does not begin with 'ply'", remedy="this is no PLY; is its type another?")
    feed = b"\r\n" if text[3:5] == b"\r\n" else text[3:4]
    end = text.find(feed + b"end_header")
    stop = text.find(feed, end + len(feed)) if end >= 0 else -1
    if feed not in (b"\n", b"\r", b"\r\n") or stop < 0:
        raise source.error("the header does not end with 'end_header'", remedy="the file is cut short or damaged")
    encoding: Encoding | None = None
    elements: list[tuple[str, int, list[Property]]] = []
    for at, line in enumerate(text[:end].split(feed), 1):
        words = line.decode("latin-1").split()
        try:
            if words[:1] == ["format"]:
                encoding = _ENCODINGS[words[1]]
            elif words[:1] == ["element"]:
                _, name, count = words
                if not (count.isascii() and count.isdigit() and len(count) <= 18):
                    raise ValueError(count)
                elements.append((name, int(count), []))
            elif words[:1] == ["property"]:
                elements[-1][2].append(property_of(words))
        except (KeyError, ValueError, IndexError):
            shown = " ".join(words)[:60]
            raise source.error(f"{shown!r} is not understood", "repair the header", at) from None
    if encoding is None:
        raise source.error("the header names no format", remedy="ascii, binary_little_endian or binary_big_endian")
    for name, _, properties in elements:
        often = Counter(known.name for known in properties)
        twice = next((known for known, count in often.items() if count > 1), None)
        if twice is not None:
            raise source.error(f"the element {name!r} has the property {twice!r} twice", remedy="repair the header")
    found = tuple(Element(name, count, tuple(properties)) for name, count, properties in elements)
    return Header(encoding, found, stop + len(feed), text[:stop].count(feed) + 1)


def read_ply(source: Source, scale: float, notes: tuple[str, ...]) -> MemoryTriangles:
    """Return the faces of a PLY, with coordinates of the type that the header names."""
    header = read_header(source)
    chosen = []
    for name in _WANTED:
        named = [element for element in header.elements if element.name == name]
        if not named and name == "face":
            raise source.error("has no element 'face'", remedy="export a mesh of triangles, not a cloud of points")
        if len(named) != 1:
            raise source.error(f"has {len(named)} elements {name!r}", remedy="one is needed")
        chosen += named
    vertex, face = chosen
    for axis in _AXES:
        if not any(known.name == axis and not known.length for known in vertex.properties):
            raise source.error(f"vertices have no property {axis!r}", remedy="they need numbers x, y and z")
    lists = [known for known in face.properties if known.length]
    indexed = [known for known in lists if known.name in _INDICES] or lists
    if not indexed:
        raise source.error("faces have no list of vertex indices", remedy="add property list uchar int vertex_indices")
    if indexed[0].type in "fd":
        raise source.error(f"the indices {indexed[0].name!r} are of type float", remedy="indices are integers")
    found = (_read_text if header.encoding == "ascii" else _read_binary)(source, header)
    single = all(known.type == "f" for known in vertex.properties if known.name in _AXES)
    with np.errstate(over="ignore"):
        columns = [np.asarray(found["vertex"][axis][1]) for axis in _AXES]
        vertices: Corners = np.stack(columns, axis=1).astype(np.float32 if single else np.float64)
    sizes, corners = map(np.asarray, found["face"][indexed[0].name])
    return polygon_triangles(
        source.name,
        vertices,
        corners.astype(np.int64),
        sizes,
        significand=24 if single else 53,
        scale=scale,
        notes=notes,
    )


def _read_text(source: Source, header: Header) -> dict[str, _Columns]:
    rows = ((line, words) for line, text in lines(source, header.size, header.lines + 1) if (words := text.split()))
    found = {}
    for element in header.elements:
        columns: _Columns = {
            known.name: (array("q"), array("d" if known.type in "fd" else "q")) for known in element.properties
        }
        found[element.name] = columns
        for there in range(element.count if element.properties else 0):
            line, words = next(rows, (0, []))
            if not words:
                what = f"the header promises {element.count} of the element {element.name!r}, {there} are there"
                raise source.error(what, remedy=TRUNCATED)
            if element.name not in _WANTED:
                continue
            rest, short = iter(words), False
            for known in element.properties:
                length = indices(source, line, [next(rest, "-1")])[0] if known.length else 1
                taken = [*islice(rest, max(length, 0))]
                short = len(taken) != length
                if short:
                    break
                lengths, values = columns[known.name]
                lengths.append(length)
                values.extend(numbers(source, line, taken) if known.type in "fd" else indices(source, line, taken))
            if short or next(rest, None) is not None:
                what = f"the line has not the number of words that an element {element.name!r} needs"
                raise source.error(what, "one line holds all properties of one element", line)
    return found


def _read_binary(source: Source, header: Header) -> dict[str, _Columns]:
    """Return the properties of each element up to the last that is wanted: rows of one length at once."""
    data, at, found = source.data(), header.size, dict[str, _Columns]()
    for element in header.elements:
        if set(_WANTED) <= set(found):
            break
        if not element.count or not element.properties:
            found[element.name] = _walked(source, data, at, element, header.encoding, 0)[1]
            continue
        least = sum(np.dtype(known.length or known.type).itemsize for known in element.properties)
        if element.count * least > len(data) - at:
            raise _too_short(source, element, (len(data) - at) // least)
        _, first = _walked(source, data, at, element, header.encoding, 1)
        fields: list[tuple[str, str, tuple[int]]] = []
        for known in element.properties:
            if known.length:
                fields.append((f"length of {known.name}", header.encoding + known.length, (1,)))
            fields.append((known.name, header.encoding + known.type, (first[known.name][0][0],)))
        row = np.dtype(fields)
        if element.count * row.itemsize <= len(data) - at:
            rows = np.frombuffer(data, row, element.count, at)
            lists = [known.name for known in element.properties if known.length]
            if all((rows[f"length of {name}"] == first[name][0][0]).all() for name in lists):
                found[element.name] = {
                    name: (np.full(len(rows), lengths[0]), rows[name].reshape(-1))
                    for name, (lengths, _) in first.items()
                }
                at += element.count * row.itemsize
                continue
        at, found[element.name] = _walked(source, data, at, element, header.encoding, element.count)
    return found


def _too_short(source: Source, element: Element, there: int) -> MeshError:
    what = f"the header promises {element.count} of the element {element.name!r}, the bytes are enough for {there}"
    return source.error(what, remedy=TRUNCATED)


def _walked(source: Source, data: bytes, at: int, element: Element, order: str, rows: int) -> tuple[int, _Columns]:
    """Return where some rows end, and the lengths and the values of each property in them."""
    columns: _Columns = {known.name: (array("q"), array(known.type)) for known in element.properties}
    for row in range(rows):
        try:
            for known in element.properties:
                length = 1
                if known.length:
                    (length,) = unpack_from(order + known.length, data, at)
                    at += calcsize(order + known.length)
                form, (lengths, values) = f"{order}{length}{known.type}", columns[known.name]
                values.extend(unpack_from(form, data, at))
                lengths.append(length)
                at += calcsize(form)
        except error:
            raise _too_short(source, element, row) from None
    return at, columns
