"""PLY, text and binary: the elements `vertex` and `face`; others are passed over."""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.read.text import TRUNCATED, indices, lines, number
from robodyn.solids.mesh.triangles import Corners, IndexedTriangles, Indices, polygon_triangles

Encoding = Literal["ascii", "<", ">"]

_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("int64", "longlong"), "i8"),
    **dict.fromkeys(("uint64", "ulonglong"), "u8"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_ENCODINGS: dict[str, Encoding] = {"ascii": "ascii", "binary_little_endian": "<", "binary_big_endian": ">"}
_LONGEST = 1 << 20


@dataclass(frozen=True)
class Property:
    """A number, or a list whose length is a number of type `length`; types as NumPy codes without byte order."""

    name: str
    type: str
    length: str | None


@dataclass(frozen=True)
class Element:
    name: str
    count: int
    properties: tuple[Property, ...]


@dataclass(frozen=True)
class Header:
    encoding: Encoding
    elements: tuple[Element, ...]
    size: int
    """Bytes of the header: the data begin there."""


def read_header(source: Source) -> Header:
    """Return the header of a PLY.

    Raises:
        MeshError: it is malformed, or does not end within 1 MB.
    """
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
                elements.append((name, _count(count), []))
            elif words[:1] == ["property"]:
                elements[-1][2].append(_property(words))
        except (KeyError, ValueError, IndexError):
            shown = " ".join(words)[:60]
            raise source.error(f"{shown!r} is not understood", "repair the header", at) from None
    if encoding is None:
        raise source.error("the header names no format", remedy="ascii, binary_little_endian or binary_big_endian")
    found = tuple(Element(name, count, tuple(properties)) for name, count, properties in elements)
    return Header(encoding, found, stop + len(feed))


def _count(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= 18):
        raise ValueError(text)
    return int(text)


def _property(words: list[str]) -> Property:
    if words[1] == "list":
        _, _, length, kind, name = words
        if _TYPES[length].startswith("f"):
            raise ValueError(length)
        return Property(name, _TYPES[kind], _TYPES[length])
    _, kind, name = words
    return Property(name, _TYPES[kind], None)


_AXES = ("x", "y", "z")
_INDICES = ("vertex_indices", "vertex_index")


def read_ply(source: Source, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
    """Return the faces of a PLY, with coordinates of the type that the header names.

    Raises:
        MeshError: the header or the data are malformed, or fewer data follow than the header promises.
    """
    header = read_header(source)
    wanted = {"vertex": _AXES, "face": (_list_of_faces(source, header),)}
    found = (_read_text if header.encoding == "ascii" else _read_binary)(source, header, wanted)
    vertices = _vertices(found)
    sizes, corners = found["face", wanted["face"][0]]
    return polygon_triangles(
        source.name,
        vertices,
        corners,
        sizes,
        significand=24 if vertices.dtype == np.float32 else 53,
        scale=scale,
        notes=notes,
    )


def _vertices(found: dict[tuple[str, str], tuple[Indices, Corners]]) -> Corners:
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


Columns = dict[tuple[str, str], tuple[Indices, NDArray[Any]]]
"""By element and property: (rows,) lengths, 1 where it is no list, and all values, one row after the other."""


def _read_text(source: Source, header: Header, wanted: Mapping[str, Sequence[str]]) -> Columns:
    """Return the wanted properties, one line for each row of an element.

    Raises:
        MeshError: a line has not as many words as its properties need, a word is no number, or lines are missing.
    """
    waiting = [element for element in header.elements if element.count and element.properties]
    lengths = {(element, name): array("q") for element, names in wanted.items() for name in names}
    types = {(element.name, known.name): known.type for element in header.elements for known in element.properties}
    values = {key: array("d" if types[key].startswith("f") else "q") for key in lengths}
    read = 0
    for line, text in lines(source, header.size):
        words = text.split()
        if not words:
            continue
        if not waiting:
            break
        element = waiting[0]
        if element.name in wanted:
            _read_row(source, line, words, element, lengths, values)
        read += 1
        if read == element.count:
            waiting, read = waiting[1:], 0
    if waiting:
        what = f"the header promises {waiting[0].count} of the element {waiting[0].name!r}, {read} are there"
        raise source.error(what, remedy=TRUNCATED)
    found = {}
    for key, column in values.items():
        numbers = np.array(column)
        with np.errstate(over="ignore"):
            found[key] = np.array(lengths[key]), numbers.astype(types[key]) if types[key].startswith("f") else numbers
    return found


def _read_row(
    source: Source,
    line: int,
    words: list[bytes],
    element: Element,
    lengths: Mapping[tuple[str, str], array[int]],
    values: Mapping[tuple[str, str], array[Any]],
) -> None:
    """Take the properties of one row."""
    at = 0
    for known in element.properties:
        length = 1
        if known.length and at < len(words):
            length = indices(source, line, words[at : at + 1])[0]
            at += 1
        if length < 0 or at + length > len(words):
            break
        key = element.name, known.name
        if key in lengths:
            lengths[key].append(length)
            taken = words[at : at + length]
            is_float = known.type.startswith("f")
            values[key].extend(
                [number(source, line, word) for word in taken] if is_float else indices(source, line, taken)
            )
        at += length
    else:
        if at == len(words):
            return
    what = f"the line has not the number of words that an element {element.name!r} needs"
    raise source.error(what, "one line holds all properties of one element", line)


def _read_binary(source: Source, header: Header, wanted: Mapping[str, Sequence[str]]) -> Columns:
    """Return the wanted properties of each element.

    Raises:
        MeshError: fewer bytes follow than the header promises.
    """
    data, at, missing = source.data(), header.size, set(wanted)
    found: Columns = {}
    for element in header.elements:
        if missing and element.properties and element.count:
            at, columns = _element(source, data, at, element, header.encoding)
            found.update({(element.name, name): columns[name] for name in wanted.get(element.name, ())})
        elif element.name in missing:
            found.update({(element.name, name): (np.empty(0, np.int64),) * 2 for name in wanted[element.name]})
        missing -= {element.name}
    return found


def _element(
    source: Source, data: bytes, at: int, element: Element, order: str
) -> tuple[int, dict[str, tuple[Indices, NDArray[Any]]]]:
    """Return where the next element begins, and the properties: rows of one length at once, others one by one."""
    least = sum(np.dtype(known.length or known.type).itemsize for known in element.properties)
    if element.count * least > len(data) - at:
        raise _too_short(source, element, (len(data) - at) // least)
    _, places = _walked(source, data, at, element, order, 1)
    fields: list[tuple[str, str, tuple[int]]] = []
    for i, (known, (_, lengths)) in enumerate(zip(element.properties, places, strict=True)):
        if known.length:
            fields.append((f"length {i}", order + known.length, (1,)))
        fields.append((f"value {i}", order + known.type, (lengths[0],)))
    row = np.dtype(fields)
    if element.count * row.itemsize <= len(data) - at:
        rows = np.frombuffer(data, row, element.count, at)
        lists = [f"length {i}" for i, known in enumerate(element.properties) if known.length]
        if all((rows[name] == rows[name][0]).all() for name in lists):
            return at + element.count * row.itemsize, {
                known.name: (np.full(len(rows), lengths[0]), _native(rows[f"value {i}"].reshape(-1)))
                for i, (known, (_, lengths)) in enumerate(zip(element.properties, places, strict=True))
            }
    end, places = _walked(source, data, at, element, order, element.count)
    return end, {
        known.name: _gathered(data, starts, lengths, order + known.type)
        for known, (starts, lengths) in zip(element.properties, places, strict=True)
    }


def _too_short(source: Source, element: Element, there: int) -> MeshError:
    what = f"the header promises {element.count} of the element {element.name!r}, the bytes are enough for {there}"
    return source.error(what, remedy=TRUNCATED)


def _walked(
    source: Source, data: bytes, at: int, element: Element, order: str, rows: int
) -> tuple[int, list[tuple[array[int], array[int]]]]:
    """Return where some rows end, and where the values of each property stand in them, and how many they are."""
    endian: Literal["big", "little"] = "big" if order == ">" else "little"
    steps = [
        (array("q"), array("q"), known.length, np.dtype(known.length or "u1").itemsize, np.dtype(known.type).itemsize)
        for known in element.properties
    ]
    for row in range(rows):
        for starts, lengths, kind, width, item in steps:
            length = 1
            if kind:
                length = int.from_bytes(data[at : at + width], endian, signed=kind.startswith("i"))
                at += width
            starts.append(at)
            lengths.append(length)
            at += length * item
            if at > len(data) or length < 0:
                raise _too_short(source, element, row)
    return at, [(starts, lengths) for starts, lengths, *_ in steps]


def _gathered(data: bytes, starts: array[int], lengths: array[int], kind: str) -> tuple[Indices, NDArray[Any]]:
    item = np.dtype(kind).itemsize
    sizes = np.frombuffer(lengths, np.int64)
    within = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    places = np.repeat(np.frombuffer(starts, np.int64), sizes) + item * within
    values = sliding_window_view(np.frombuffer(data, np.uint8), item)[places].view(kind)[:, 0]
    return sizes, _native(values)


def _native(values: NDArray[Any]) -> NDArray[Any]:
    return values.astype(values.dtype.newbyteorder("="))
