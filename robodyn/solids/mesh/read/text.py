"""Meshes as text, line by line: Wavefront OBJ, OFF and STL, and what text of PLY needs as well.

Read here since trimesh takes an index 0, negative ones of OBJ and cut text of PLY for others, without a word.
"""

from __future__ import annotations

import math
import re
from array import array
from collections.abc import Iterator
from io import BytesIO, TextIOWrapper
from itertools import count, islice

import numpy as np

from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.triangles import MemoryTriangles, polygon_triangles

_LONGEST_LINE = 1 << 24
_INDEX = re.compile(r"[-+]?[0-9]{1,18}")
_INDICES = re.compile(rf"(?:{_INDEX.pattern} )*")
TRUNCATED = "the file is cut short: get it again"
_SAMPLE = 1024
_EXACT, _FLOAT32, _FLOAT64 = 5, 9, 16
_OFF = re.compile(r"(?:ST)?C?N?OFF")
_FACET = ("facet", "outer", "vertex", "vertex", "vertex", "endloop", "endfacet")
"""How the lines of a facet begin."""


def lines(source: Source, start: int = 0, first: int = 1) -> Iterator[tuple[int, str]]:
    """The lines of a file from a byte on, whatever ends them, numbered from `first`; raises where one is over 16 MB."""
    text = TextIOWrapper(BytesIO(source.data()[start:]), "utf-8-sig", "replace")
    for number in count(first):
        line = text.readline(_LONGEST_LINE)
        if len(line) == _LONGEST_LINE:
            raise source.error("a line longer than 16 MB", "is it the text of a mesh?", number)
        if not line:
            return
        yield number, line


def numbers(source: Source, line: int, words: list[str]) -> list[float]:
    """Return the decimal numbers that words are, correctly rounded; `nan` and `inf` are numbers."""
    found = []
    for word in words:
        try:
            found.append(float(word if "_" not in word else ""))
        except ValueError:
            shown = word[:40] + ("..." if len(word) > 40 else "")
            remedy = "a coordinate is a decimal number such as -1.5e-3"
            remedy = "write decimals with a point" if "," in word else remedy
            raise source.error(f"{shown!r} is not a number", remedy, line) from None
    return found


def _point(source: Source, line: int, words: list[str]) -> list[float]:
    if len(words) < 3:
        raise source.error(f"a vertex with {len(words)} coordinates", "write x y z", line)
    return numbers(source, line, words[:3])


def indices(source: Source, line: int, words: list[str]) -> list[int]:
    """Return the integers, of at most 18 digits, that words are."""
    if not _INDICES.fullmatch(" ".join([*words, ""])):
        word = next(word for word in words if not _INDEX.fullmatch(word))
        raise source.error(f"{word[:40]!r} is not an index", "indices are integers", line)
    return [*map(int, words)]


def significand_of(coordinates: array[float]) -> int:
    """Return to how many bits the numbers of a text are rounded, told from some of them. Fewer than 5 digits are taken
    as exact, as in a box drawn by hand: 53; up to 9 are written for float32: at most 24."""
    step = len(coordinates) // _SAMPLE + 1
    some = coordinates[:: step + (step % 3 == 0)]  # x, y and z in turn
    digits = max((len(repr(x).partition("e")[0].replace(".", "").strip("-0")) for x in some), default=0)
    if not _EXACT <= digits < _FLOAT64:
        return 53
    return min(math.floor(digits * math.log2(10.0)), 24 if digits <= _FLOAT32 else 53)


class _Polygons:
    """Vertices and polygons of a text; the corners of a polygon count from 0."""

    def __init__(self) -> None:
        self.coordinates, self.corners, self.sizes = array("d"), array("q"), array("q")

    def triangles(self, source: Source, scale: float, notes: tuple[str, ...]) -> MemoryTriangles:
        return polygon_triangles(
            source.name,
            np.array(self.coordinates).reshape(-1, 3),
            np.array(self.corners),
            np.array(self.sizes),
            significand=significand_of(self.coordinates),
            scale=scale,
            notes=notes,
        )


def read_obj(source: Source, scale: float, notes: tuple[str, ...]) -> MemoryTriangles:
    """Return the faces of all objects and groups of an OBJ: lines `v x y z` and `f i/t/n j/t/n k/t/n ...`. Indices
    count from 1, negative ones backwards from the last vertex that stands before the face. Texture and normal indices,
    weights and colours are left out."""
    found = _Polygons()
    coordinates, sizes, corners = found.coordinates, found.sizes, found.corners
    for line, words in _obj_lines(source):
        if words[0] == "v":
            coordinates.extend(_point(source, line, words[1:]))
        elif words[0] == "f":
            if len(words) < 4:
                raise source.error(f"a face with {len(words) - 1} corners", "a face needs three; leave it out", line)
            given = indices(source, line, [word.partition("/")[0] or word for word in words[1:]])
            if min(given) < 1:
                before = len(coordinates) // 3
                if 0 in given or min(given) < -before:
                    corner = next(corner for corner in given if corner == 0 or corner < -before)
                    remedy = "indices count from 1, or back from -1"
                    raise source.error(f"vertex {corner} of the {before} before this face", remedy, line)
                given = [corner if corner > 0 else before + corner + 1 for corner in given]
            sizes.append(len(given))
            corners.extend([corner - 1 for corner in given])
    if not found.coordinates and not found.sizes:
        raise source.error("no line begins with 'v' or 'f'", remedy="this is no OBJ; is its type another?")
    return found.triangles(source, scale, notes)


def _obj_lines(source: Source) -> Iterator[tuple[int, list[str]]]:
    """The words of each line that has any, without comments; a line that ends in a backslash goes on in the next."""
    before: list[str] = []
    line = 0
    for line, text in lines(source):
        said, comment, _ = text.partition("#")
        words = said.split()
        if words and not comment and words[-1].endswith("\\"):
            before += [*words[:-1], *filter(None, [words[-1][:-1]])]
        elif before or words:
            yield line, before + words
            before = []
    if before:
        yield line, before


def read_off(source: Source, scale: float, notes: tuple[str, ...]) -> MemoryTriangles:
    """Return the faces, `n i j k ...`, of an OFF; colours, normals and texture coordinates are left out."""
    rows = ((line, words) for line, text in lines(source) if (words := text.partition("#")[0].split()))
    _, header = next(rows, (0, [""]))
    counts = header[1:] or next(rows, (0, []))[1]
    if not _OFF.fullmatch(header[0]) or not 2 <= len(counts) <= 3 or not all(map(_INDEX.fullmatch, counts)):
        what = "does not begin with 'OFF' and the numbers of vertices and faces"
        raise source.error(what, remedy="only the text of 3-dimensional OFF is read")
    points, faces = abs(int(counts[0])), abs(int(counts[1]))
    found = _Polygons()
    for line, words in islice(rows, points):
        found.coordinates.extend(_point(source, line, words))
    for line, words in islice(rows, faces):
        size = indices(source, line, words[:1])[0]
        if not 3 <= size < len(words):
            what = f"a face of {size} corners with {len(words) - 1} words after that number"
            raise source.error(what, "write n and then n indices, at least three", line)
        found.corners.extend(indices(source, line, words[1 : size + 1]))
        found.sizes.append(size)
    there = {"vertices": (len(found.coordinates) // 3, points), "faces": (len(found.sizes), faces)}
    for name, (read, promised) in there.items():
        if read < promised:
            raise source.error(f"the header promises {promised} {name}, {read} are there", remedy=TRUNCATED)
    return found.triangles(source, scale, notes)


def read_stl_text(source: Source, scale: float, notes: tuple[str, ...]) -> MemoryTriangles:
    """Return the facets of all solids of a text, in any case of letters; normals are left out."""
    corners = array("d")
    solids, is_open, at = 0, False, 0
    for line, text in lines(source):
        words = text.split()
        word = words[0].lower() if words else ""
        if word == _FACET[at]:
            if word == "vertex":
                corners.extend(_point(source, line, words[1:]))
            at = (at + 1) % len(_FACET)
        elif at == 0 and word in ("solid", "endsolid"):
            is_open = word == "solid"
            solids += is_open
        elif words and _FACET[at].startswith(word):
            break
        elif words:
            what = f"{words[0][:40]!r} where {_FACET[at]!r} should stand"
            raise source.error(what, "a facet has three vertices", line)
    if at:
        raise source.error(f"ends where {_FACET[at]!r} should follow", remedy=TRUNCATED)
    if not corners:
        raise source.error("holds no facets", remedy="export the mesh again")
    if is_open or not solids:
        missing = "without 'endsolid'" if is_open else "but no line begins with 'solid'"
        raise source.error(f"{len(corners) // 9} facets {missing}", remedy=TRUNCATED)
    if solids > 1:
        notes = (*notes, f"{solids} solids are taken together")
    found = np.array(corners).reshape(-1, 3, 3)
    return MemoryTriangles(source.name, found, significand=significand_of(corners), scale=scale, notes=notes)
