"""Binary STL, streamed: 80 bytes of header, the number of triangles, then 50 bytes for each of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.triangles import BLOCK, Corners, Triangles, checked

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
    found = np.empty((3, 3, len(corners)), np.float32)
    found[...] = corners.transpose(1, 2, 0)
    return found.transpose(2, 0, 1)


def open_binary(source: Source, head: bytes, scale: float, notes: tuple[str, ...]) -> StlTriangles:
    """Return the triangles of a file that begins with `head`."""
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
