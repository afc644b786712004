"""Triangles of a mesh in blocks, wherever they are kept."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import MeshError

Floats = NDArray[np.float64]
Corners = NDArray[np.floating[Any]]

BLOCK = 4096
"""Triangles of a block: its corners stay in the cache."""


class Triangles(Protocol):
    """The triangles of a mesh, all with finite corners, to be read as often as wanted.

    name: as messages name the mesh; count: number of triangles, at least one;
    significand: bits to which the file rounds a coordinate (24 for float32), relative to the largest one;
    scale: metres per unit of the file; notes: what was assumed or left out when the mesh was read;
    warnings: why what was read may not be the whole mesh.
    """

    @property
    def name(self) -> str: ...

    @property
    def count(self) -> int: ...

    @property
    def significand(self) -> int: ...

    @property
    def scale(self) -> float: ...

    @property
    def notes(self) -> tuple[str, ...]: ...

    @property
    def warnings(self) -> tuple[str, ...]: ...

    def blocks(self, rows: int = BLOCK) -> Iterator[Corners]:
        """Consecutive blocks (n, 3, 3), 1 <= n <= rows, of corners in units of the file, float32 or float64.

        Axes are triangle, corner, coordinate, with any strides; a block must not be written to.

        Raises:
            MeshError: a corner is not finite (the face is named), or the file changed since it was opened.
        """
        ...

    def array(self) -> Floats:
        """All corners, (count, 3, 3) in units of the file."""
        ...


@dataclass(frozen=True, eq=False)
class MemoryTriangles:
    """Triangles of an array (m, 3, 3); see `Triangles`."""

    name: str
    corners: Corners
    significand: int = 53
    scale: float = 1.0
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def count(self) -> int:
        return len(self.corners)

    def blocks(self, rows: int = BLOCK) -> Iterator[Corners]:
        for k, block in enumerate(self.records(rows)):
            check_finite(block, k * rows, self.name)
            yield block

    def records(self, rows: int = BLOCK) -> Iterator[Corners]:
        """The blocks, perhaps with corners that are not finite."""
        for start in range(0, self.count, rows):
            yield self.corners[start : start + rows]

    def array(self) -> Floats:
        check_finite(self.corners, 0, self.name)
        return self.corners.astype(np.float64)


@dataclass(frozen=True, eq=False)
class IndexedTriangles:
    """Triangles of vertices (v, 3) and faces (m, 3) of indices, every used vertex finite; see `Triangles`."""

    name: str
    vertices: Corners
    faces: NDArray[np.signedinteger[Any]]
    significand: int = 53
    scale: float = 1.0
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def count(self) -> int:
        return len(self.faces)

    def blocks(self, rows: int = BLOCK) -> Iterator[Corners]:
        for start in range(0, self.count, rows):
            yield self.vertices[self.faces[start : start + rows]]

    def array(self) -> Floats:
        corners: Floats = self.vertices[self.faces].astype(np.float64, copy=False)
        return corners

    def indexed(self) -> tuple[Corners, NDArray[np.signedinteger[Any]]]:
        """Vertices (v, 3), some perhaps unused and then perhaps not finite, and faces (m, 3)."""
        return self.vertices, self.faces


def check_finite(block: Corners, first: int, name: str) -> None:
    """Name the first triangle with a corner that is not finite.

    Args:
        block: (n, 3, 3); first: how many triangles came before it.

    Raises:
        MeshError: there is one.
    """
    finite = np.isfinite(block)
    if finite.all():
        return
    row, corner, _ = np.argwhere(~finite)[0]
    raise not_finite(first + int(row), block[row, corner], name)


def check_all_finite(triangles: Triangles) -> None:
    """Name the first triangle with a corner that is not finite, as every reading of the blocks does."""
    for _ in triangles.blocks():
        pass


def not_finite(face: int, corner: Corners, name: str) -> MeshError:
    """The error of a face, counted from 0, that has this corner."""
    place = ", ".join(f"{value:g}" for value in corner)
    return MeshError(f"face {face + 1} has a corner at ({place})", remedy="coordinates must be finite", file=name)


def box(triangles: Triangles) -> tuple[Floats, Floats]:
    """The least and the largest coordinates of all corners, (3,) each, in units of the file."""
    lo, hi = np.full(3, np.inf), np.full(3, -np.inf)
    for block in triangles.blocks():
        lo = np.minimum(lo, block.min(axis=(0, 1)))
        hi = np.maximum(hi, block.max(axis=(0, 1)))
    return lo, hi
