"""The data of a binary PLY: rows of fixed length, or of lists of any length."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.lines import Integers, runs
from robodyn.solids.mesh.read.ply_header import Element, Header
from robodyn.solids.mesh.read.source import Source

Columns = dict[tuple[str, str], tuple[Integers, NDArray[Any]]]
"""By element and property: (rows,) lengths, 1 where it is no list, and all values, one row after the other."""


def read_binary(source: Source, header: Header, wanted: Mapping[str, Sequence[str]]) -> Columns:
    """Return the wanted properties of each element.

    Raises:
        MeshError: fewer bytes follow than the header promises.
    """
    data = source.data()
    found: Columns = {}
    at, missing = header.size, set(wanted)
    for element in header.elements:
        if not missing:
            break
        names = wanted.get(element.name, ())
        at, columns = _element(source, data, at, element, header.encoding, names)
        found.update({(element.name, name): column for name, column in columns.items()})
        missing -= {element.name}
    return found


def _element(
    source: Source, data: bytes, at: int, element: Element, order: str, wanted: Sequence[str]
) -> tuple[int, dict[str, tuple[Integers, NDArray[Any]]]]:
    """Return where the next element begins, and the wanted properties."""
    if not element.properties:
        return at, {}
    least = sum(np.dtype(known.length or known.type).itemsize for known in element.properties)
    if element.count * least > len(data) - at:
        raise _too_short(source, element, (len(data) - at) // least)
    lengths = _first_lengths(data, at, element, order) if element.count else None
    if lengths is not None:
        row = _row(element, order, lengths)
        if element.count * row.itemsize <= len(data) - at:
            rows = np.frombuffer(data, row, element.count, at)
            if all((rows[f"length {i}"] == length).all() for i, length in enumerate(lengths) if length is not None):
                return at + element.count * row.itemsize, _uniform(element, rows, lengths, wanted)
    return _walked(source, data, at, element, order, wanted)


def _too_short(source: Source, element: Element, there: int) -> MeshError:
    what = f"the header promises {element.count} of the element {element.name!r}, the bytes are enough for {there}"
    return source.error(what, remedy="the file is cut short: get it again")


def _first_lengths(data: bytes, at: int, element: Element, order: str) -> list[int | None] | None:
    """Return the lengths of the lists in the first row, None for numbers; None altogether if the row does not fit."""
    lengths: list[int | None] = []
    for known in element.properties:
        length = None
        if known.length:
            length = _integer(data, at, known.length, order)
            at += np.dtype(known.length).itemsize
            if length < 0:
                return None
        lengths.append(length)
        at += (1 if length is None else length) * np.dtype(known.type).itemsize
        if at > len(data):
            return None
    return lengths


def _integer(data: bytes, at: int, kind: str, order: str) -> int:
    size = np.dtype(kind).itemsize
    return int.from_bytes(data[at : at + size], "big" if order == ">" else "little", signed=kind.startswith("i"))


def _row(element: Element, order: str, lengths: list[int | None]) -> np.dtype[np.void]:
    fields: list[tuple[str, str, int]] = []
    for i, (known, length) in enumerate(zip(element.properties, lengths, strict=True)):
        if known.length:
            fields.append((f"length {i}", order + known.length, 1))
        fields.append((f"value {i}", order + known.type, 1 if length is None else length))
    return np.dtype([(name, kind, (count,)) for name, kind, count in fields])


def _uniform(
    element: Element, rows: NDArray[np.void], lengths: list[int | None], wanted: Sequence[str]
) -> dict[str, tuple[Integers, NDArray[Any]]]:
    found = {}
    for i, (known, length) in enumerate(zip(element.properties, lengths, strict=True)):
        if known.name in wanted:
            sizes = np.full(len(rows), 1 if length is None else length)
            found[known.name] = sizes, _native(rows[f"value {i}"].reshape(-1))
    return found


def _walked(
    source: Source, data: bytes, at: int, element: Element, order: str, wanted: Sequence[str]
) -> tuple[int, dict[str, tuple[Integers, NDArray[Any]]]]:
    """Row by row, because a row says by its lists where the next one begins."""
    places = {name: (array("q"), array("q")) for name in wanted}
    steps = [
        (places.get(known.name), known.length, np.dtype(known.length or "u1").itemsize, np.dtype(known.type).itemsize)
        for known in element.properties
    ]
    for row in range(element.count):
        for place, kind, width, item in steps:
            length = 1
            if kind:
                length = data[at] if kind == "u1" and at < len(data) else _integer(data, at, kind, order)
                at += width
            if place:
                place[0].append(at)
                place[1].append(length)
            at += length * item
            if at > len(data) or length < 0:
                raise _too_short(source, element, row)
    found = {}
    for known in element.properties:
        if known.name in wanted:
            found[known.name] = _gathered(data, *places[known.name], order + known.type)
    return at, found


def _gathered(data: bytes, starts: array[int], lengths: array[int], kind: str) -> tuple[Integers, NDArray[Any]]:
    item = np.dtype(kind).itemsize
    sizes = np.frombuffer(lengths, np.int64)
    places = np.repeat(np.frombuffer(starts, np.int64), sizes) + item * runs(np.zeros_like(sizes), sizes)
    values = sliding_window_view(np.frombuffer(data, np.uint8), item)[places].view(kind)[:, 0]
    return sizes, _native(values)


def _native(values: NDArray[Any]) -> NDArray[Any]:
    return values.astype(values.dtype.newbyteorder("="))
