"""Wavefront OBJ: lines `v x y z` and `f i/t/n j/t/n k/t/n ...`; all other lines do not matter here."""

from __future__ import annotations

import re

import numpy as np

from robodyn.solids.mesh.read.lines import Integers, Tokens, last_line_end, runs, tokens, whole_lines, without_comments
from robodyn.solids.mesh.read.polygons import Polygons
from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.triangles import IndexedTriangles

_CONTINUED = re.compile(rb"\\\r?\n")


def read_obj(source: Source, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
    """Return the faces of all objects and groups of an OBJ.

    Indices count from 1, negative ones backwards from the last vertex that stands before the face. Texture and normal
    indices, weights and colours are left out.

    Raises:
        MeshError: a line of a vertex or a face is malformed, a face names a vertex that does not exist, there are none.
    """
    found = Polygons()
    with source.opened() as stream:
        for offset, text in whole_lines(source, stream, _end):
            _take(found, tokens(source, offset, _plain(text)))
    if not found.points and not found.faces:
        raise source.error("no line begins with 'v' or 'f'", remedy="this is no OBJ; is its type another?")
    return found.triangles(source, scale, notes)


def _end(text: bytes) -> int:
    end = last_line_end(text)
    while text[:end].rstrip(b"\r\n").endswith(b"\\"):
        end = last_line_end(text[: end - 1].rstrip(b"\r\n"))
    return end


def _plain(text: bytes) -> bytes:
    """The text with blanks for comments, and lines joined that end with a backslash; every word stays in its place."""
    text = without_comments(text)
    return _CONTINUED.sub(lambda found: b" " * len(found[0]), text) if b"\\" in text else text


def _take(found: Polygons, words: Tokens) -> None:
    first, lengths = words.first[:-1], np.diff(words.first)
    is_vertex = words.begin_with(b"v")
    short = is_vertex & (lengths < 4)
    if short.any():
        at = int(short.argmax())
        raise words.error(int(first[at]), f"a vertex with {lengths[at] - 1} coordinates", "write v x y z")
    lines = np.flatnonzero(words.begin_with(b"f"))
    before = found.points + np.cumsum(is_vertex)[lines]
    found.add_vertices(words, first[is_vertex] + 1)
    if len(lines):
        _take_faces(found, words, first[lines] + 1, lengths[lines] - 1, before)


def _take_faces(found: Polygons, words: Tokens, first: Integers, sizes: Integers, before: Integers) -> None:
    """Faces whose corners are `sizes` words from `first` on, with `before` vertices before them."""
    if (sizes < 3).any():
        at = int((sizes < 3).argmax())
        raise words.error(int(first[at]) - 1, f"a face with {sizes[at]} corners", "a face needs three; leave it out")
    index = runs(first, sizes)
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
    found.add_faces(corners - 1, sizes)
