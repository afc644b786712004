"""Wavefront OBJ: lines `v x y z` and `f i/t/n j/t/n k/t/n ...`; all other lines do not matter here."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from robodyn.solids.mesh.read.lines import Integers, Tokens, last_line_end, tokens, whole_lines
from robodyn.solids.mesh.read.polygons import add_sample, significand, triangles_of
from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.triangles import Floats, IndexedTriangles

_COMMENT = re.compile(rb"#[^\r\n]*")
_CONTINUED = re.compile(rb"\\\r?\n")


@dataclass
class _Parts:
    vertices: list[Floats] = field(default_factory=list)
    corners: list[Integers] = field(default_factory=list)
    sizes: list[Integers] = field(default_factory=list)
    words: list[bytes] = field(default_factory=list)
    count: int = 0


def read_obj(source: Source, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
    """The faces of all objects and groups of an OBJ.

    Indices count from 1, negative ones backwards from the last vertex that stands before the face. Texture and normal
    indices, weights and colours are left out.

    Raises:
        MeshError: a line of a vertex or a face is malformed, a face names a vertex that does not exist, there are none.
    """
    parts = _Parts()
    with source.opened() as stream:
        for offset, text in whole_lines(source, stream, _end):
            _take(parts, tokens(source, offset, _plain(text)))
    if not parts.count and not parts.sizes:
        raise source.error("no line begins with 'v' or 'f'", remedy="this is no OBJ; is its type another?")
    return triangles_of(
        source.name,
        np.concatenate([np.empty((0, 3)), *parts.vertices]),
        np.concatenate([np.empty(0, np.int64), *parts.corners]),
        np.concatenate([np.empty(0, np.int64), *parts.sizes]),
        significand=significand(parts.words),
        scale=scale,
        notes=notes,
    )


def _end(text: bytes) -> int:
    end = last_line_end(text)
    while text[:end].rstrip(b"\r\n").endswith(b"\\"):
        end = last_line_end(text[: end - 1].rstrip(b"\r\n"))
    return end


def _plain(text: bytes) -> bytes:
    """The text with blanks for comments, and lines joined that end with a backslash; every word stays in its place."""
    if b"#" in text:
        text = _COMMENT.sub(_blanks, text)
    return _CONTINUED.sub(_blanks, text) if b"\\" in text else text


def _blanks(found: re.Match[bytes]) -> bytes:
    return b" " * len(found[0])


def _take(parts: _Parts, words: Tokens) -> None:
    first, lengths = words.first[:-1], np.diff(words.first)
    is_vertex = words.begin_with(b"v")
    short = is_vertex & (lengths < 4)
    if short.any():
        at = int(short.argmax())
        what = f"a vertex with {lengths[at] - 1} coordinates"
        raise words.error(int(first[at]), what, "write v x y z")
    coordinates = first[is_vertex][:, None] + np.arange(1, 4)
    if len(coordinates):
        add_sample(parts.words, words, coordinates)
        parts.vertices.append(words.floats(coordinates.reshape(-1)).reshape(-1, 3))
    lines = np.flatnonzero(words.begin_with(b"f"))
    if len(lines):
        before = parts.count + np.cumsum(is_vertex)[lines]
        _take_faces(parts, words, first[lines] + 1, lengths[lines] - 1, before)
    parts.count += len(coordinates)


def _take_faces(parts: _Parts, words: Tokens, first: Integers, sizes: Integers, before: Integers) -> None:
    """Faces whose corners are `sizes` words from `first` on, with `before` vertices before them."""
    if (sizes < 3).any():
        at = int((sizes < 3).argmax())
        raise words.error(int(first[at]) - 1, f"a face with {sizes[at]} corners", "a face needs three; leave it out")
    starts = np.repeat(first - (np.cumsum(sizes) - sizes), sizes)
    index = starts + np.arange(len(starts))
    corners = words.integers(index, slash=True)
    relative = corners <= 0
    if relative.any():
        there = np.repeat(before, sizes)
        counted = corners + there + 1
        wrong = relative & ((corners == 0) | (counted <= 0))
        if wrong.any():
            at = int(wrong.argmax())
            what = f"vertex {corners[at]} of the {there[at]} before this face"
            raise words.error(int(index[at]), what, "indices count from 1, or back from -1")
        corners = np.where(relative, counted, corners)
    parts.corners.append(corners - 1)
    parts.sizes.append(sizes)
