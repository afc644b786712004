"""Polygons as text: Wavefront OBJ, lines `v x y z` and `f i/t/n j/t/n k/t/n ...`; all others do not matter here.

And OFF: the word OFF, the numbers of vertices and faces, vertices, and faces as `n i j k ...`.
"""

from __future__ import annotations

import re

import numpy as np

from robodyn.solids.mesh.read.lines import Integers, Tokens, chunks, last_line_end, runs, without_comments
from robodyn.solids.mesh.read.polygons import Polygons
from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.triangles import IndexedTriangles

_OFF = re.compile(rb"\s*(?:ST)?C?N?OFF\s+(\d{1,18})[ \t]+(\d{1,18})([ \t]+\d{1,18})?[ \t]*(?=[\r\n])")
_HEAD = 1 << 16


def read_obj(source: Source, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
    """Return the faces of all objects and groups of an OBJ.

    Indices count from 1, negative ones backwards from the last vertex that stands before the face. Texture and normal
    indices, weights and colours are left out.

    Raises:
        MeshError: a line of a vertex or a face is malformed, a face names a vertex that does not exist, there are none.
    """
    found = Polygons()
    for words in chunks(source, end=_obj_end, plain=_obj_plain):
        first, lengths = words.first[:-1], np.diff(words.first)
        is_vertex = words.begin_with(b"v")
        few = is_vertex & (lengths < 4)
        words.refuse(few, first, "a vertex with {} coordinates", "write v x y z", lengths - 1)
        lines = np.flatnonzero(words.begin_with(b"f"))
        before = found.points + np.cumsum(is_vertex)[lines]
        found.add_vertices(words, first[is_vertex] + 1)
        if len(lines):
            sizes = lengths[lines] - 1
            found.add_faces(_obj_corners(words, first[lines] + 1, sizes, before), sizes)
    if not found.points and not found.faces:
        raise source.error("no line begins with 'v' or 'f'", remedy="this is no OBJ; is its type another?")
    return found.triangles(source, scale, notes)


def _obj_end(text: bytes) -> int:
    """Just after the last line that the next one does not continue."""
    return last_line_end(_continued(text))


def _obj_plain(text: bytes) -> bytes:
    """The text with blanks for comments, and lines joined that end with a backslash; every word stays in its place."""
    return _continued(without_comments(text))


def _continued(text: bytes) -> bytes:
    """Return the text with blanks for a backslash and the end of the line after it."""
    return text.replace(b"\\\r\n", b"   ").replace(b"\\\n", b"  ") if b"\\" in text else text


def _obj_corners(words: Tokens, first: Integers, sizes: Integers, before: Integers) -> Integers:
    """The vertices, from 0 on, of faces of so many words from `first` on, with `before` vertices before them."""
    words.refuse(sizes < 3, first - 1, "a face with {} corners", "a face needs three; leave it out", sizes)
    index = runs(first, sizes)
    corners = words.integers(index, slash=True)
    relative = corners <= 0
    if not relative.any():
        return corners - 1
    there = np.repeat(before, sizes)
    counted = corners + there + 1
    wrong = relative & ((corners == 0) | (counted <= 0))
    what, remedy = "vertex {} of the {} before this face", "indices count from 1, or back from -1"
    words.refuse(wrong, index, what, remedy, corners, there)
    return np.where(relative, counted, corners) - 1


def read_off(source: Source, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
    """Return the faces of an OFF, colours, normals and texture coordinates left out.

    Raises:
        MeshError: the header or a line is malformed, or fewer lines follow than the header promises.
    """
    header = _OFF.match(without_comments(source.data(_HEAD)))
    if header is None:
        what = "does not begin with 'OFF' and the numbers of vertices and faces"
        raise source.error(what, remedy="only the text of 3-dimensional OFF is read")
    points, faces = int(header[1]), int(header[2])
    found = Polygons()
    for words in chunks(source, header.end(), plain=without_comments):
        first, lengths = words.first[:-1], np.diff(words.first)
        end = min(len(first), points - found.points)
        rows = slice(end, end + faces - found.faces)
        few = lengths[:end] < 3
        words.refuse(few, first, "a vertex with {} coordinates", "write x y z", lengths)
        found.add_vertices(words, first[:end])
        if len(first[rows]):
            _add_off_faces(found, words, first[rows], lengths[rows])
    for name, there, wanted in (("vertices", found.points, points), ("faces", found.faces, faces)):
        if there < wanted:
            what = f"the header promises {wanted} {name}, {there} are there"
            raise source.error(what, remedy="the file is cut short: get it again")
    return found.triangles(source, scale, notes)


def _add_off_faces(found: Polygons, words: Tokens, first: Integers, lengths: Integers) -> None:
    sizes = words.integers(first)
    wrong, what = (sizes < 3) | (sizes >= lengths), "a face of {} corners with {} words after that number"
    words.refuse(wrong, first, what, "write n and then n indices, at least three", sizes, lengths - 1)
    found.add_faces(words.integers(runs(first + 1, sizes)), sizes)
