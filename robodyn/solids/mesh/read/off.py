"""OFF as text: the word OFF, the numbers of vertices and faces, vertices, and faces as `n i j k ...`."""

from __future__ import annotations

import re

import numpy as np

from robodyn.solids.mesh.read.lines import Integers, Tokens, last_line_end, tokens, whole_lines
from robodyn.solids.mesh.read.polygons import add_sample, significand, triangles_of
from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.triangles import Floats, IndexedTriangles

_COMMENT = re.compile(rb"#[^\r\n]*")
_HEADER = re.compile(rb"\s*(?:ST)?C?N?OFF\s+(\d{1,18})[ \t]+(\d{1,18})([ \t]+\d{1,18})?[ \t]*(?=[\r\n])")
_HEAD = 1 << 16


def read_off(source: Source, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
    """The faces of an OFF, colours, normals and texture coordinates left out.

    Raises:
        MeshError: the header or a line is malformed, or fewer lines follow than the header promises.
    """
    head = _COMMENT.sub(lambda found: b" " * len(found[0]), source.data(_HEAD))
    header = _HEADER.match(head)
    if header is None:
        what = "does not begin with 'OFF' and the numbers of vertices and faces"
        raise source.error(what, remedy="only the text of 3-dimensional OFF is read")
    promised = [int(header[1]), int(header[2])]
    reader = _Reader(promised)
    with source.opened() as stream:
        stream.seek(header.end())
        for offset, text in whole_lines(source, stream, last_line_end):
            reader.take(tokens(source, offset, _COMMENT.sub(lambda found: b" " * len(found[0]), text)))
    for name, there, wanted in zip(("vertices", "faces"), reader.rows, promised, strict=True):
        if there < wanted:
            what = f"the header promises {wanted} {name}, {there} are there"
            raise source.error(what, remedy="the file is cut short: get it again")
    return triangles_of(
        source.name,
        np.concatenate([np.empty((0, 3)), *reader.vertices]),
        np.concatenate([np.empty(0, np.int64), *reader.corners]),
        np.concatenate([np.empty(0, np.int64), *reader.sizes]),
        significand=significand(reader.words),
        scale=scale,
        notes=notes,
    )


class _Reader:
    """Takes the lines of vertices, then those of faces."""

    def __init__(self, promised: list[int]) -> None:
        self.promised, self.rows = promised, [0, 0]
        self.vertices: list[Floats] = []
        self.corners: list[Integers] = []
        self.sizes: list[Integers] = []
        self.words: list[bytes] = []

    def take(self, words: Tokens) -> None:
        first, lengths = words.first[:-1], np.diff(words.first)
        end = min(len(first), self.promised[0] - self.rows[0])
        self._vertices(words, first[:end], lengths[:end])
        stop = min(len(first), end + self.promised[1] - self.rows[1])
        self._faces(words, first[end:stop], lengths[end:stop])
        self.rows = [self.rows[0] + end, self.rows[1] + stop - end]

    def _vertices(self, words: Tokens, first: Integers, lengths: Integers) -> None:
        if not len(first):
            return
        if (lengths < 3).any():
            at = int((lengths < 3).argmax())
            raise words.error(int(first[at]), f"a vertex with {lengths[at]} coordinates", "write x y z")
        coordinates = first[:, None] + np.arange(3)
        add_sample(self.words, words, coordinates)
        self.vertices.append(words.floats(coordinates.reshape(-1)).reshape(-1, 3))

    def _faces(self, words: Tokens, first: Integers, lengths: Integers) -> None:
        if not len(first):
            return
        sizes = words.integers(first)
        wrong = (sizes < 3) | (sizes >= lengths)
        if wrong.any():
            at = int(wrong.argmax())
            what = f"a face of {sizes[at]} corners with {lengths[at] - 1} words after that number"
            raise words.error(int(first[at]), what, "write n and then n indices, at least three")
        index = np.repeat(first + 1 - (np.cumsum(sizes) - sizes), sizes) + np.arange(sizes.sum())
        self.corners.append(words.integers(index))
        self.sizes.append(sizes)
