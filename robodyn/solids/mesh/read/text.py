"""Meshes as text, line by line: Wavefront OBJ, OFF and STL, and what text of PLY needs as well.

OBJ has lines `v x y z` and `f i/t/n j/t/n k/t/n ...`; all others do not matter here. OFF has the word OFF, the numbers
of vertices and faces, vertices, and faces as `n i j k ...`. STL has `facet normal x y z`, `outer loop`, three times
`vertex x y z`, `endloop`, `endfacet`, each on a line of its own.
"""

from __future__ import annotations

import math
import re
from array import array
from collections.abc import Iterable, Iterator

import numpy as np

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.triangles import IndexedTriangles, MemoryTriangles, polygon_triangles

_LONGEST_LINE = 1 << 24
_MARK = b"\xef\xbb\xbf"
_HEAD = 1 << 16
_READ = 1 << 18
TRUNCATED = "the file is cut short: get it again"


def _parts(source: Source, start: int = 0) -> Iterator[tuple[int, bytes]]:
    """Whole lines of a file from a byte on, some hundred kB at a time, with the number of the first."""
    with source.opened() as stream:
        before = stream.read(start)
        number = len(before.splitlines()) + (before[-1:] in (b"", b"\n", b"\r"))
        rest = b""
        while data := stream.read(_READ):
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
    """The lines of a file from a byte on, whatever ends them, each with its number; raises where one is over 16 MB."""
    for first, text in _parts(source, start):
        yield from enumerate(text.splitlines(), first)


def _too_long(source: Source, line: int) -> MeshError:
    return source.error("a line longer than 16 MB", remedy="is it the text of a mesh?", line=line)


def number(source: Source, line: int, word: bytes) -> float:
    """Return the decimal number that a word is, correctly rounded; `nan` and `inf` are numbers."""
    try:
        if b"_" not in word:
            return float(word)
    except ValueError:
        pass
    shown = word[:40].decode("utf-8", "replace") + ("..." if len(word) > 40 else "")
    remedy = "write decimals with a point" if b"," in word else "a coordinate is a decimal number such as -1.5e-3"
    raise source.error(f"{shown!r} is not a number", remedy, line)


def _point(source: Source, line: int, words: list[bytes]) -> list[float]:
    """Return the first three words as coordinates."""
    if len(words) < 3:
        raise source.error(f"a vertex with {len(words)} coordinates", "write x y z", line)
    return [number(source, line, word) for word in words[:3]]


def indices(source: Source, line: int, words: list[bytes], slash: bool = False) -> list[int]:
    """Return the integers, of at most 18 digits, that words are or, with `slash`, that stand before the first `/`."""
    found = [word.partition(b"/")[0] for word in words] if slash else words
    if b"".join(found).isdigit() and all(found) and max(map(len, found)) <= 18:
        return [*map(int, found)]
    for word, said in zip(words, found, strict=True):
        if len(said) > 18 or not re.fullmatch(rb"[-+]?\d+", said):
            shown = word[:40].decode("utf-8", "replace")
            raise source.error(f"{shown!r} is not an index", "indices are integers", line)
    return [int(said) for said in found]


_SAMPLE = 1024
_EXACT, _FLOAT32, _FLOAT64 = 5, 9, 16


def significand_of(coordinates: array[float]) -> int:
    """Return to how many bits the numbers of a text are rounded, told from some of them.

    Fewer than 5 digits are taken as exact, as in a box drawn by hand: 53; up to 9 are written for float32: at most 24.
    """
    step = len(coordinates) // _SAMPLE + 1
    some = coordinates[:: step + (step % 3 == 0)]  # x, y and z in turn
    digits = max((len(repr(x).partition("e")[0].replace(".", "").strip("-0")) for x in some), default=0)
    if not _EXACT <= digits < _FLOAT64:
        return 53
    return min(math.floor(digits * math.log2(10.0)), 24 if digits <= _FLOAT32 else 53)


class _Polygons:
    """Vertices and polygons of a text."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._coordinates, self._corners, self._sizes = array("d"), array("q"), array("q")

    @property
    def points(self) -> int:
        return len(self._coordinates) // 3

    @property
    def faces(self) -> int:
        return len(self._sizes)

    def add_vertex(self, line: int, words: list[bytes]) -> None:
        self._coordinates.extend(_point(self._source, line, words))

    def add_face(self, corners: Iterable[int]) -> None:
        """Take the numbers of its vertices, from 0 on."""
        before = len(self._corners)
        self._corners.extend(corners)
        self._sizes.append(len(self._corners) - before)

    def add_vertices(self, text: bytes) -> bool:
        """Take lines of `v x y z`; return whether all are numbers, and take nothing if they are not."""
        try:
            self._coordinates.extend(array("d", map(float, text.replace(b"v", b" ").split())))
        except ValueError:
            return False
        return True

    def add_triangles(self, text: bytes) -> bool:
        """Take lines of `f i/t/n j/t/n k/t/n`; return whether no index is 0, and take nothing if one is."""
        corners = np.array([*map(int, _REST.sub(b"", text).replace(b"f", b" ").split())], dtype=np.int64)
        if not corners.all():
            return False
        self._corners.frombytes((corners - 1).tobytes())
        self._sizes.extend([3] * (len(corners) // 3))
        return True

    def triangles(self, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
        return polygon_triangles(
            self._source.name,
            np.array(self._coordinates).reshape(-1, 3),
            np.array(self._corners),
            np.array(self._sizes),
            significand=significand_of(self._coordinates),
            scale=scale,
            notes=notes,
        )


_REST = re.compile(rb"/[^ \t\n]*")
"""Indices of texture coordinates and normals, behind that of a vertex."""

_CONTINUED = re.compile(rb"(?m)^([^#\n]*)\\\n")
"""A line that the next one goes on with."""

_RUN = re.compile(
    rb"((?:v(?:[ \t]+[-+.\deE]+){3}[ \t]*\n)+)"
    rb"|((?:f(?:[ \t]+\d{1,18}(?:/\d*){0,2}){3}[ \t]*\n)+)"
    rb"|((?:v[nt][^\n]*\n)+)"
)
"""Lines of plain vertices, of triangles whose indices count from 1, and of normals and texture coordinates."""
_VERTICES, _TRIANGLES, _OTHERS = 1, 2, 3
_PART = 1 << 18
"""Bytes of a run, at most: its numbers stay in the cache."""


def read_obj(source: Source, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
    """Return the faces of all objects and groups of an OBJ.

    Indices count from 1, negative ones backwards from the last vertex that stands before the face. Texture and normal
    indices, weights and colours are left out.
    """
    found = _Polygons(source)
    given = source.data().removeprefix(_MARK).replace(b"\r\n", b"\n").replace(b"\r", b"\n") + b"\n"
    text = _CONTINUED.sub(rb"\1  ", given) if b"\\\n" in given else given  # as long, so that places are the same
    text += b"\n"
    at = 0
    while at + _LONGEST_LINE < len(text):
        end = text.rfind(b"\n", at, at + _LONGEST_LINE + 1) + 1
        if not end:
            raise _too_long(source, given.count(b"\n", 0, at) + 1)
        at = end
    line, at = 1, 0
    while at < len(text):
        run = _RUN.match(text, at, at + _PART)
        end = run.end() if run else text.index(b"\n", at) + 1
        part, kind = text[at:end], run.lastindex if run else None
        taken = kind == _OTHERS or (kind == _VERTICES and found.add_vertices(part))
        if not taken and not (kind == _TRIANGLES and found.add_triangles(part)):
            for own, said in enumerate(part.splitlines(), line):
                _take_obj_line(found, source, own, said.partition(b"#")[0].split())
        line, at = line + given.count(b"\n", at, end), end
    if not found.points and not found.faces:
        raise source.error("no line begins with 'v' or 'f'", remedy="this is no OBJ; is its type another?")
    return found.triangles(scale, notes)


def _take_obj_line(found: _Polygons, source: Source, line: int, words: list[bytes]) -> None:
    """Take the vertex or the face that a line is, if it is one."""
    if words[:1] == [b"v"]:
        found.add_vertex(line, words[1:])
    elif words[:1] == [b"f"]:
        if len(words) < 4:
            raise source.error(f"a face with {len(words) - 1} corners", "a face needs three; leave it out", line)
        corners, before = indices(source, line, words[1:], slash=True), found.points
        for corner in corners:
            if corner == 0 or corner < -before:
                remedy = "indices count from 1, or back from -1"
                raise source.error(f"vertex {corner} of the {before} before this face", remedy, line)
        found.add_face(corner - 1 if corner > 0 else before + corner for corner in corners)


_OFF = re.compile(rb"\s*(?:ST)?C?N?OFF\s+(\d{1,18})[ \t]+(\d{1,18})([ \t]+\d{1,18})?[ \t]*(?=[\r\n])")
_COMMENT = re.compile(rb"#[^\r\n]*")


def read_off(source: Source, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
    """Return the faces of an OFF, colours, normals and texture coordinates left out."""
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


_FACET = (b"facet", b"outer", b"vertex", b"vertex", b"vertex", b"endloop", b"endfacet")
"""How the lines of a facet begin."""


def read_stl_text(source: Source, scale: float, notes: tuple[str, ...]) -> MemoryTriangles:
    """Return the facets of all solids of a text, in any case of letters; normals are left out."""
    corners = array("d")
    solids, is_open, at = 0, False, 0
    for line, text in lines(source):
        words = text.split()
        if not words:
            continue
        word = words[0].lower()
        if word == _FACET[at]:
            if word == b"vertex":
                corners.extend(_point(source, line, words[1:]))
            at = (at + 1) % len(_FACET)
        elif at == 0 and word in (b"solid", b"endsolid"):
            is_open = word == b"solid"
            solids += is_open
        elif _FACET[at].startswith(word):
            break
        else:
            what = f"{words[0][:40].decode('utf-8', 'replace')!r} where {_FACET[at].decode()!r} should stand"
            raise source.error(what, "a facet has three vertices", line)
    if at:
        raise source.error(f"ends where {_FACET[at].decode()!r} should follow", remedy=TRUNCATED)
    count = len(corners) // 9
    if not count:
        raise source.error("holds no facets", remedy="export the mesh again")
    if is_open or not solids:
        missing = "without 'endsolid'" if is_open else "but no line begins with 'solid'"
        raise source.error(f"{count} facets {missing}", remedy=TRUNCATED)
    if solids > 1:
        notes = (*notes, f"{solids} solids are taken together")
    found = np.array(corners).reshape(-1, 3, 3)
    return MemoryTriangles(source.name, found, significand=significand_of(corners), scale=scale, notes=notes)
