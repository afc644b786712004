"""The data of an ASCII PLY: a line for every row of an element."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.solids.mesh.lines import Integers, Tokens, last_line_end, tokens, whole_lines
from robodyn.solids.mesh.ply_binary import Columns
from robodyn.solids.mesh.ply_header import Element, Header
from robodyn.solids.mesh.source import Source


def read_text(source: Source, header: Header, wanted: Mapping[str, Sequence[str]]) -> Columns:
    """The wanted properties; see `read_binary`.

    Raises:
        MeshError: a line has not as many words as its properties need, a word is no number, or lines are missing.
    """
    parts: dict[tuple[str, str], list[tuple[Integers, NDArray[Any]]]] = {}
    for element in header.elements:
        parts.update({(element.name, name): [] for name in wanted.get(element.name, ())})
    waiting = [element for element in header.elements if element.count and element.properties]
    read = 0
    with source.opened() as stream:
        stream.seek(header.size)
        for offset, text in whole_lines(source, stream, last_line_end):
            words = tokens(source, offset, text)
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
    """The wanted properties of some lines."""
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
                index = np.repeat(at - (np.cumsum(sizes) - sizes), sizes) + np.arange(sizes.sum())
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
    bad = (at >= end) | wrong
    if bad.any():
        first = int(bad.argmax())
        line = int(end[first]) - 1
        what = f"the line has not the number of words that an element {element.name!r} needs"
        raise words.error(line, what, "one line holds all properties of one element")
