"""The header of a PLY: which elements follow, how many, and of what properties."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from robodyn.solids.mesh.read.source import Source

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
    offset = 0
    for line in text[:end].split(feed):
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
            raise source.error(f"{shown!r} is not understood", "repair the header", offset) from None
        offset += len(line) + len(feed)
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
