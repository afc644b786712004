"""Meshes as text, line by line: Wavefront OBJ, OFF, and what text of PLY and STL needs as well.

OBJ has lines `v x y z` and `f i/t/n j/t/n k/t/n ...`; all others do not matter here. OFF has the word OFF, the numbers
of vertices and faces, vertices, and faces as `n i j k ...`.
"""

from __future__ import annotations

import math
import re
from array import array
from collections.abc import Iterator

import numpy as np

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.triangles import IndexedTriangles, polygon_triangles

_PART = 1 << 18
_LONGEST_LINE = 1 << 24
_MARK = b"\xef\xbb\xbf"
_OFF = re.compile(rb"\s*(?:ST)?C?N?OFF\s+(\d{1,18})[ \t]+(\d{1,18})([ \t]+\d{1,18})?[ \t]*(?=[\r\n])")
_COMMENT = re.compile(rb"#[^\r\n]*")
_HEAD = 1 << 16
_REST = re.compile(rb"/[^ \t\n]*")
"""Indices of texture coordinates and normals, behind that of a vertex."""
TRUNCATED = "the file is cut short: get it again"


def _parts(source: Source, start: int = 0) -> Iterator[tuple[int, bytes]]:
    """Whole lines of a file from a byte on, some hundred kB at a time, with the number of the first.

    Raises:
        MeshError: a line is longer than 16 MB.
    """
    with source.opened() as stream:
        before = stream.read(start)
        number = len(before.splitlines()) + (before[-1:] in (b"", b"\n", b"\r"))
        rest = b""
        while data := stream.read(_PART):
            text = rest + data
            if number == 1 and text.startswith(_MARK):
                text = text[len(_MARK) :]
            end = text.rfind(b"\n") + 1 or text.rfind(b"\r", 0, -1) + 1
            rest = text[end:]
            if end:
                yield number, text[:end]
                number += len(text[:end].splitlines())
            if len(rest) > _LONGEST_LINE:
                raise _too_long(source, number)
        yield number, rest


def lines(source: Source, start: int = 0) -> Iterator[tuple[int, bytes]]:
    """The lines of a file from a byte on, whatever ends them, each with its number.

    Raises:
        MeshError: one is longer than 16 MB.
    """
    for first, text in _parts(source, start):
        yield from enumerate(text.splitlines(), first)


def _too_long(source: Source, line: int) -> MeshError:
    return source.error("a line longer than 16 MB", remedy="is it the text of a mesh?", line=line)


def number(source: Source, line: int, word: bytes) -> float:
    """Return the decimal number that a word is, correctly rounded; `nan` and `inf` are numbers.

    Raises:
        MeshError: it is not one.
    """
    try:
        if b"_" not in word:
            return float(word)
    except ValueError:
        pass
    shown = word[:40].decode("utf-8", "replace") + ("..." if len(word) > 40 else "")
    remedy = "write decimals with a point" if b"," in word else "a coordinate is a decimal number such as -1.5e-3"
    raise source.error(f"{shown!r} is not a number", remedy, line)


def point(source: Source, line: int, words: list[bytes]) -> list[float]:
    """Return the first three words as coordinates."""
    if len(words) < 3:
        raise source.error(f"a vertex with {len(words)} coordinates", "write x y z", line)
    try:
        found = [float(word) for word in words[:3]]
    except ValueError:
        found = []
    if not found or b"_" in b"".join(words[:3]):
        return [number(source, line, word) for word in words[:3]]
    return found


def indices(source: Source, line: int, words: list[bytes], slash: bool = False) -> list[int]:
    """Return the integers that words are or, with `slash`, that stand before the first `/` in them.

    Raises:
        MeshError: a word is not one of at most 18 digits.
    """
    digits = [word.partition(b"/")[0] for word in words] if slash else words
    joined = b"".join(digits)
    if not joined.isdigit() or b"" in digits or (len(joined) > 18 and max(map(len, digits)) > 18):
        for word, said in zip(words, digits, strict=True):
            if len(said) > 18 or not re.fullmatch(rb"[-+]?\d+", said):
                shown = word[:40].decode("utf-8", "replace")
                raise source.error(f"{shown!r} is not an index", "indices are integers", line)
    return [int(said) for said in digits]


class Digits:
    """To how many bits the numbers of a text are rounded, told from some of them."""

    _MOST, _EACH = 1024, 32
    _FEW, _FLOAT32, _FLOAT64 = 5, 9, 16

    def __init__(self) -> None:
        self._lines = self._words = self._digits = 0

    def see(self, words: list[bytes]) -> None:
        """Count the digits of these words, of one line in 32 at most, zeros at their ends left out."""
        if self._lines % self._EACH == 0 and self._words < self._MOST:
            for word in words:
                mantissa = word.lower().partition(b"e")[0].lstrip(b"+-")
                self._digits = max(self._digits, len(mantissa.replace(b".", b"").strip(b"0")))
            self._words += len(words)
        self._lines += 1

    @property
    def enough(self) -> bool:
        """Whether no more words are looked at."""
        return self._words >= self._MOST

    @property
    def significand(self) -> int:
        """Bits of the numbers.

        Numbers of fewer than 5 digits are taken as exact, as in a box drawn by hand: 53. Up to 9 digits are what
        programs write for float32: at most 24.
        """
        if not self._FEW <= self._digits < self._FLOAT64:
            return 53
        bits = math.floor(self._digits * math.log2(10.0))
        return min(bits, 24 if self._digits <= self._FLOAT32 else 53)


class _Polygons:
    """Vertices and polygons of a text, taken line by line."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._coordinates, self._corners, self._sizes = array("d"), array("q"), array("q")
        self._digits = Digits()

    @property
    def points(self) -> int:
        return len(self._coordinates) // 3

    @property
    def faces(self) -> int:
        return len(self._sizes)

    def add_vertex(self, line: int, words: list[bytes]) -> None:
        self._coordinates.extend(point(self._source, line, words))
        self._digits.see(words[:3])

    def add_vertices(self, text: bytes) -> bool:
        """Take lines of `v x y z`; return whether all are numbers, and take nothing if they are not."""
        try:
            coordinates = array("d", map(float, text.replace(b"v", b" ").split()))
        except ValueError:
            return False
        self._coordinates.extend(coordinates)
        if not self._digits.enough:
            for line in text.splitlines():
                self._digits.see(line.split()[1:])
        return True

    def add_triangles(self, text: bytes) -> bool:
        """Take lines of `f i/t/n j/t/n k/t/n`; return whether no index is 0, and take nothing if one is."""
        corners = np.array([*map(int, _REST.sub(b"", text).replace(b"f", b" ").split())], dtype=np.int64)
        if not corners.all():
            return False
        self._corners.frombytes((corners - 1).tobytes())
        self._sizes.extend([3] * (len(corners) // 3))
        return True

    def add_face(self, corners: list[int]) -> None:
        """Take the numbers of its vertices, from 0 on."""
        self._corners.extend(corners)
        self._sizes.append(len(corners))

    def triangles(self, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
        return polygon_triangles(
            self._source.name,
            np.array(self._coordinates).reshape(-1, 3),
            np.array(self._corners),
            np.array(self._sizes),
            significand=self._digits.significand,
            scale=scale,
            notes=notes,
        )


def read_obj(source: Source, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
    """Return the faces of all objects and groups of an OBJ.

    Indices count from 1, negative ones backwards from the last vertex that stands before the face. Texture and normal
    indices, weights and colours are left out.

    Raises:
        MeshError: a line of a vertex or a face is malformed, a face names a vertex that does not exist, there are none.
    """
    found = _Polygons(source)
    begun, parts, size = 0, list[bytes](), 0
    for first, text, kind in _obj_runs(source):
        if kind == _OTHERS or (kind == _VERTICES and found.add_vertices(text)):
            continue
        if kind == _TRIANGLES and found.add_triangles(text):
            continue
        for line, said in enumerate(text.splitlines(), first):
            begun = begun or line
            words = said.partition(b"#")[0].split()
            if said[-1:] == b"\\" and b"#" not in said:  # the next line goes on with this one
                size += len(said) + 1
                if size > _LONGEST_LINE:
                    raise _too_long(source, begun)
                parts += said[:-1].split()
                continue
            _take_obj_line(found, source, begun, parts + words)
            begun, parts, size = 0, [], 0
    _take_obj_line(found, source, begun, parts)
    if not found.points and not found.faces:
        raise source.error("no line begins with 'v' or 'f'", remedy="this is no OBJ; is its type another?")
    return found.triangles(scale, notes)


_VERTICES, _TRIANGLES, _OTHERS = 1, 2, 3
_RUN = re.compile(
    rb"((?:v(?:[ \t]+[-+.\deE]+){3}[ \t]*\n)+)"
    rb"|((?:f(?:[ \t]+\d{1,18}(?:/\d*){0,2}){3}[ \t]*\n)+)"
    rb"|((?:v[nt][^\n\\]*\n)+)"
)
"""Lines of plain vertices, of triangles whose indices count from 1, and of normals and texture coordinates."""


def _obj_runs(source: Source) -> Iterator[tuple[int, bytes, int]]:
    """Runs of lines of one kind, each with the number of its first line, and other lines one by one with kind 0."""
    joined = False
    for first, part in _parts(source):
        text, line, at = part.replace(b"\r\n", b"\n"), first, 0
        if b"\r" in text:
            text = b"\n".join(text.splitlines()) + b"\n"
        while at < len(text):
            run = None if joined else _RUN.match(text, at)
            end = run.end() if run else text.find(b"\n", at) + 1 or len(text)
            piece = text[at:end]
            yield line, piece, (run.lastindex or 0) if run else 0
            joined = piece.rstrip(b"\n")[-1:] == b"\\"
            line, at = line + (piece.count(b"\n") if run else 1), end


def _take_obj_line(found: _Polygons, source: Source, line: int, words: list[bytes]) -> None:
    """Take the vertex or the face that a line is, if it is one."""
    if words[:1] == [b"v"]:
        found.add_vertex(line, words[1:])
    elif words[:1] == [b"f"]:
        if len(words) < 4:
            what = f"a face with {len(words) - 1} corners"
            raise source.error(what, "a face needs three; leave it out", line)
        found.add_face(_obj_corners(source, line, words[1:], found.points))


def _obj_corners(source: Source, line: int, words: list[bytes], before: int) -> list[int]:
    """The vertices of a face, from 0 on, with so many vertices before it."""
    corners = indices(source, line, words, slash=True)
    if min(corners) > 0:
        return [corner - 1 for corner in corners]
    for corner in corners:
        if corner == 0 or corner < -before:
            remedy = "indices count from 1, or back from -1"
            raise source.error(f"vertex {corner} of the {before} before this face", remedy, line)
    return [corner - 1 if corner > 0 else before + corner for corner in corners]


def read_off(source: Source, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
    """Return the faces of an OFF, colours, normals and texture coordinates left out.

    Raises:
        MeshError: the header or a line is malformed, or fewer lines follow than the header promises.
    """
    head = _COMMENT.sub(lambda found: b" " * len(found[0]), source.data(_HEAD))
    header = _OFF.match(head)
    if header is None:
        what = "does not begin with 'OFF' and the numbers of vertices and faces"
        raise source.error(what, remedy="only the text of 3-dimensional OFF is read")
    points, faces = int(header[1]), int(header[2])
    found = _Polygons(source)
    for line, text in lines(source, header.end()):
        words = text.partition(b"#")[0].split()
        if not words:
            continue
        if found.points < points:
            found.add_vertex(line, words)
        elif found.faces < faces:
            size = indices(source, line, words[:1])[0]
            if not 3 <= size < len(words):
                what = f"a face of {size} corners with {len(words) - 1} words after that number"
                raise source.error(what, "write n and then n indices, at least three", line)
            found.add_face(indices(source, line, words[1 : size + 1]))
    for name, there, wanted in (("vertices", found.points, points), ("faces", found.faces, faces)):
        if there < wanted:
            raise source.error(f"the header promises {wanted} {name}, {there} are there", remedy=TRUNCATED)
    return found.triangles(scale, notes)
