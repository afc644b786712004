"""OFF as text: the word OFF, the numbers of vertices and faces, vertices, and faces as `n i j k ...`."""

from __future__ import annotations

import re

import numpy as np

from robodyn.solids.mesh.read.lines import Integers, Tokens, last_line_end, runs, tokens, whole_lines, without_comments
from robodyn.solids.mesh.read.polygons import Polygons
from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.triangles import IndexedTriangles

_HEADER = re.compile(rb"\s*(?:ST)?C?N?OFF\s+(\d{1,18})[ \t]+(\d{1,18})([ \t]+\d{1,18})?[ \t]*(?=[\r\n])")
_HEAD = 1 << 16


def read_off(source: Source, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
    """Return the faces of an OFF, colours, normals and texture coordinates left out.

    Raises:
        MeshError: the header or a line is malformed, or fewer lines follow than the header promises.
    """
    head = without_comments(source.data(_HEAD))
    header = _HEADER.match(head)
    if header is None:
        what = "does not begin with 'OFF' and the numbers of vertices and faces"
        raise source.error(what, remedy="only the text of 3-dimensional OFF is read")
    promised = int(header[1]), int(header[2])
    found = Polygons()
    with source.opened() as stream:
        stream.seek(header.end())
        for offset, text in whole_lines(source, stream, last_line_end):
            _take(found, tokens(source, offset, without_comments(text)), *promised)
    for name, there, wanted in zip(("vertices", "faces"), (found.points, found.faces), promised, strict=True):
        if there < wanted:
            what = f"the header promises {wanted} {name}, {there} are there"
            raise source.error(what, remedy="the file is cut short: get it again")
    return found.triangles(source, scale, notes)


def _take(found: Polygons, words: Tokens, points: int, faces: int) -> None:
    """Take lines of vertices until there are so many, then those of faces."""
    first, lengths = words.first[:-1], np.diff(words.first)
    end = min(len(first), points - found.points)
    short = lengths[:end] < 3
    if short.any():
        at = int(short.argmax())
        raise words.error(int(first[at]), f"a vertex with {lengths[at]} coordinates", "write x y z")
    found.add_vertices(words, first[:end])
    rows = slice(end, end + faces - found.faces)
    if len(first[rows]):
        _take_faces(found, words, first[rows], lengths[rows])


def _take_faces(found: Polygons, words: Tokens, first: Integers, lengths: Integers) -> None:
    sizes = words.integers(first)
    wrong = (sizes < 3) | (sizes >= lengths)
    if wrong.any():
        at = int(wrong.argmax())
        what = f"a face of {sizes[at]} corners with {lengths[at] - 1} words after that number"
        raise words.error(int(first[at]), what, "write n and then n indices, at least three")
    found.add_faces(words.integers(runs(first + 1, sizes)), sizes)
