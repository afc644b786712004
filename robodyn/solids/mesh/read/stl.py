"""STL: binary, streamed, or as text.

Binary: 80 bytes of header, the number of triangles, then 50 bytes for each of them. Text: `facet normal x y z`,
`outer loop`, three times `vertex x y z`, `endloop`, `endfacet`, each on a line of its own.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.triangles import BLOCK, Corners, MemoryTriangles, Triangles, checked

START, RECORD = 84, 50

_TYPE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def promised(head: bytes) -> int:
    """Return the number of triangles that the first 84 bytes of a file promise."""
    return int.from_bytes(head[80:START], "little")


def is_complete(head: bytes, size: int) -> bool:
    """Return whether a file of this size that begins so is exactly a binary STL, whatever the text in its header."""
    return len(head) >= START and size == START + RECORD * promised(head)


@dataclass(frozen=True, eq=False)
class StlTriangles(Triangles):
    """Triangles of a binary STL, read anew, a block at a time, whenever they are asked for.

    The coordinates of a block are contiguous: `block.transpose(1, 2, 0)` is in C order.
    """

    source: Source
    promised: int

    @property
    def count(self) -> int:
        return self.promised

    def blocks(self, rows: int = BLOCK) -> Iterator[Corners]:
        return checked(map(_columns, self.records(rows)), self.name)

    def records(self, rows: int = BLOCK) -> Iterator[Corners]:
        held = self.source.memory()
        if held is not None:
            corners = np.frombuffer(held, _TYPE, self.count, START)["corners"]
            yield from (corners[first : first + rows] for first in range(0, self.count, rows))
            return
        data = bytearray(RECORD * min(rows, self.count))
        with self.source.opened() as stream:
            for first in range(0, self.count, rows):
                wanted = RECORD * min(rows, self.count - first)
                stream.seek(START + RECORD * first)
                if stream.readinto(memoryview(data)[:wanted]) != wanted:  # type: ignore[attr-defined]
                    raise self.source.error("was cut short while it was read", remedy="run again")
                yield np.frombuffer(data, _TYPE, wanted // RECORD)["corners"]


def _columns(corners: Corners) -> Corners:
    """Return a copy of (n, 3, 3) with each of its nine columns contiguous."""
    found = np.empty((3, 3, len(corners)), np.float32)
    found[...] = corners.transpose(1, 2, 0)
    return found.transpose(2, 0, 1)


def open_binary(source: Source, head: bytes, scale: float, notes: tuple[str, ...]) -> StlTriangles:
    """Return the triangles of a file that begins with `head`.

    Raises:
        MeshError: it has no triangles, or fewer than it promises.
    """
    if len(head) < START:
        what = f"{source.size} bytes are no STL, whose header alone has {START}"
        raise source.error(what, remedy="export the mesh again")
    count, there = promised(head), (source.size - START) // RECORD
    if count > there:
        what = (
            f"the header promises {count} triangles ({START + RECORD * count} bytes), the file has {source.size} bytes"
        )
        raise source.error(f"{what}, {there} whole triangles", remedy="it is cut short or no STL: get it again")
    if not count:
        though = f", though {source.size - START} bytes follow" if source.size > START else ""
        raise source.error(f"the header promises 0 triangles{though}", remedy="export the mesh again")
    extra = source.size - START - RECORD * count
    warnings: tuple[str, ...] = ()
    if extra >= RECORD:
        warnings = (
            f"the header counts {count} triangles, the file has room for {there}: {there - count} are left out",
        )
    elif extra:
        notes = (*notes, f"{extra} bytes after the last triangle are left out")
    labels: dict[str, Any] = {"significand": 24, "scale": scale, "notes": notes, "warnings": warnings}
    return StlTriangles(source.name, source, count, **labels)


_FACET = (b"facet", b"outer", b"vertex", b"vertex", b"vertex", b"endloop", b"endfacet")
"""How the lines of a facet begin."""


def read_stl_text(source: Source, scale: float, notes: tuple[str, ...]) -> MemoryTriangles:
    """Return the facets of all solids of a text, in any case of letters; normals are left out.

    Raises:
        MeshError: there are none, one is malformed, or the last solid does not end.
    """
    from robodyn.solids.mesh.read.text import TRUNCATED, Digits, lines, point

    corners, digits = array("d"), Digits()
    solids, is_open, at = 0, False, 0
    for line, text in lines(source):
        words = text.split()
        if not words:
            continue
        word = words[0].lower()
        if word == _FACET[at]:
            if word == b"vertex":
                corners.extend(point(source, line, words[1:]))
                digits.see(words[1:4])
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
    return MemoryTriangles(source.name, found, significand=digits.significand, scale=scale, notes=notes)
