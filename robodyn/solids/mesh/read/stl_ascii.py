"""ASCII STL: `facet normal x y z`, `outer loop`, three times `vertex x y z`, `endloop`, `endfacet`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import partial

import numpy as np

from robodyn.solids.mesh.read.lines import Integers, Tokens, chunks
from robodyn.solids.mesh.read.polygons import add_sample, significand
from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.triangles import MemoryTriangles
from robodyn.support.floats import Floats

_WORDS = 21
_LAYOUT = {
    0: b"facet",
    1: b"normal",
    5: b"outer",
    6: b"loop",
    7: b"vertex",
    11: b"vertex",
    15: b"vertex",
    19: b"endloop",
    20: b"endfacet",
}
"""Where the words stand that are no numbers, among the 21 of a facet."""
_COORDINATES = np.array([8, 9, 10, 12, 13, 14, 16, 17, 18])
_SOLID = re.compile(rb"(end)?solid[^\r\n]*")
_TRUNCATED = "the file is cut short: get it again"


def read_ascii(source: Source, scale: float, notes: tuple[str, ...]) -> MemoryTriangles:
    """Return the facets of all solids of an ASCII STL, in any case of letters; normals are left out.

    Raises:
        MeshError: there are none, one is malformed, or the last solid does not end.
    """
    parts: list[Floats] = []
    words: list[bytes] = []
    names: list[bool] = []
    for found in chunks(source, end=_end, plain=partial(_without_names, names)):
        index = _coordinates(found)
        if len(index):
            add_sample(words, found, index)
            parts.append(found.floats(index.reshape(-1)).reshape(-1, 3, 3))
    count, solids, is_open = sum(map(len, parts)), names.count(True), names[-1:] == [True]
    if not count:
        raise source.error("holds no facets", remedy="export the mesh again")
    if is_open or not solids:
        missing = "without 'endsolid'" if is_open else "but no line begins with 'solid'"
        raise source.error(f"{count} facets {missing}", remedy=_TRUNCATED)
    if solids > 1:
        notes = (*notes, f"{solids} solids are taken together")
    bits = significand(words)
    return MemoryTriangles(source.name, np.concatenate(parts), significand=bits, scale=scale, notes=notes)


def _end(text: bytes) -> int:
    """Just after the last facet."""
    word = b"endfacet"
    last = max(text.rfind(word), text.rfind(word.upper()))
    return last + len(word) if last >= 0 else text.lower().rfind(word) + len(word) if word in text.lower() else 0


def _without_names(names: list[bool], text: bytes) -> bytes:
    """Return the text in lower case, lines of solids blank; names get the words solid (True) and endsolid (False)."""
    text = text.lower()
    at = text.find(b"solid")
    if at < 0:
        return text
    found = bytearray(text)
    while at >= 0:
        start = at - 3 if text[max(at - 3, 0) : at] == b"end" else at
        match = _SOLID.match(text, start)
        end = match.end() if match else at + 5
        names.append(start == at)
        found[start:end] = b" " * (end - start)
        at = text.find(b"solid", end)
    return bytes(found)


def _coordinates(words: Tokens) -> Integers:
    """(m, 9) indices of the coordinates of each facet."""
    count = len(words.starts)
    facets = np.arange(0, count, _WORDS)
    if not count % _WORDS and all(words.equal(facets + at, word) for at, word in _LAYOUT.items()):
        index: Integers = facets[:, None] + _COORDINATES
        return index
    return np.array(list(_one_by_one(words)), np.int64).reshape(-1, 9)


def _one_by_one(words: Tokens) -> Iterator[list[int]]:
    """The same, word by word, for facets with other than three numbers of a normal, and to tell what is wrong."""
    at, count = 0, len(words.starts)

    def expect(*wanted: bytes) -> None:
        nonlocal at
        for word in wanted:
            if at >= count or (at == count - 1 and word.startswith(words.word(at)) and words.word(at) != word):
                raise words.error(count - 1, f"ends where {word.decode()!r} should follow", _TRUNCATED)
            if words.word(at) != word:
                found = words.word(at)[:40].decode("utf-8", "replace")
                raise words.error(at, f"{found!r} where {word.decode()!r} should stand", "a facet has three vertices")
            at += 1

    while at < count:
        expect(b"facet")
        while at < count and words.word(at) != b"outer":
            at += 1
        expect(b"outer", b"loop")
        facet: list[int] = []
        for _ in range(3):
            expect(b"vertex")
            facet += range(at, at + 3)
            at += 3
        expect(b"endloop", b"endfacet")
        yield facet
