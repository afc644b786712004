"""Triangles of a mesh in blocks, wherever they are kept, and stretched along their axes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import MeshError
from robodyn.support.floats import Floats

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
        """Return all corners, (count, 3, 3) in units of the file."""
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
    """Return the error of a face, counted from 0, that has this corner."""
    place = ", ".join(f"{value:g}" for value in corner)
    return MeshError(f"face {face + 1} has a corner at ({place})", remedy="coordinates must be finite", file=name)


def box(triangles: Triangles) -> tuple[Floats, Floats]:
    """Return the least and the largest coordinates of all corners, (3,) each, in units of the file."""
    lo, hi = np.full(3, np.inf), np.full(3, -np.inf)
    for block in triangles.blocks():
        lo = np.minimum(lo, block.min(axis=(0, 1)))
        hi = np.maximum(hi, block.max(axis=(0, 1)))
    return lo, hi


@dataclass(frozen=True, eq=False)
class ScaledTriangles:
    """The given triangles with each coordinate times its factor; see `Triangles`.

    Of a mirror image the corners are read backwards, so that what was wound outwards still is.
    """

    given: Triangles
    factors: Floats
    name: str
    count: int
    significand: int
    scale: float
    notes: tuple[str, ...]
    warnings: tuple[str, ...]

    def blocks(self, rows: int = BLOCK) -> Iterator[Corners]:
        for block in self.given.blocks(rows):
            yield self._stretched(block)

    def array(self) -> Floats:
        return self._stretched(self.given.array()).astype(np.float64, copy=False)

    def _stretched(self, corners: Corners) -> Corners:
        if (self.factors == 1).all():
            return corners
        stretched = corners * self.factors
        return stretched[:, ::-1] if self.factors.prod() < 0 else stretched


def scaled(triangles: Triangles, factors: Sequence[float]) -> Triangles:
    """Return the triangles stretched along x, y and z; the same object where all three factors are 1.

    What the factors have in common goes into the scale, so that a change of unit changes no coordinate.

    Args:
        factors: (3,), negative ones for mirror images.

    Raises:
        MeshError: a factor is zero or not finite.
    """
    given = np.array(factors, dtype=float)
    if not (np.isfinite(given) & (given != 0)).all():
        listed = " ".join(f"{factor:g}" for factor in given)
        raise MeshError(
            f"the scale {listed} leaves no volume", remedy="give factors that are not zero", file=triangles.name
        )
    if (given == 1).all():
        return triangles
    common = float(abs(given[0]))
    kept = triangles.name, triangles.count, triangles.significand
    size = triangles.scale * common
    return ScaledTriangles(triangles, given / common, *kept, size, triangles.notes, triangles.warnings)
