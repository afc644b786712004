"""Triangles of a mesh in blocks, wherever they are kept, and stretched along their axes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import MeshError
from robodyn.support.floats import Floats

Corners = NDArray[np.floating[Any]]
Indices = NDArray[np.signedinteger[Any]]

BLOCK = 4096
"""Triangles of a block: its corners stay in the cache."""


@dataclass(frozen=True, eq=False)
class Triangles(ABC):
    """The triangles of a mesh, all with finite corners, to be read as often as wanted.

    name: as messages name the mesh; count: number of triangles, at least one;
    significand: bits to which the file rounds a coordinate (24 for float32), relative to the largest one;
    scale: metres per unit of the file; notes: what was assumed or left out when the mesh was read;
    warnings: why what was read may not be the whole mesh.
    """

    name: str
    _: KW_ONLY
    significand: int = 53
    scale: float = 1.0
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    @abstractmethod
    def count(self) -> int: ...

    @abstractmethod
    def blocks(self, rows: int = BLOCK) -> Iterator[Corners]:
        """Consecutive blocks (n, 3, 3), 1 <= n <= rows, of corners in units of the file, float32 or float64.

        Axes are triangle, corner, coordinate, with any strides; a block must not be written to.

        Raises:
            MeshError: a corner is not finite (the face is named), or the file changed since it was opened.
        """

    def records(self, rows: int = BLOCK) -> Iterator[Corners]:
        """The blocks as they come fastest: perhaps in the memory of the next, and with corners that are not finite."""
        return self.blocks(rows)

    def array(self) -> Floats:
        """Return all corners, (count, 3, 3) in units of the file."""
        found, first = np.empty((self.count, 3, 3)), 0
        for block in self.blocks():
            found[first : first + len(block)] = block
            first += len(block)
        return found

    @property
    def labels(self) -> dict[str, Any]:
        """All but the triangles, by the names of the fields."""
        return {label.name: getattr(self, label.name) for label in fields(Triangles)}


@dataclass(frozen=True, eq=False)
class MemoryTriangles(Triangles):
    """Triangles of an array (m, 3, 3)."""

    corners: Corners

    @property
    def count(self) -> int:
        return len(self.corners)

    def blocks(self, rows: int = BLOCK) -> Iterator[Corners]:
        return checked(self.records(rows), self.name)

    def records(self, rows: int = BLOCK) -> Iterator[Corners]:
        for start in range(0, self.count, rows):
            yield self.corners[start : start + rows]


@dataclass(frozen=True, eq=False)
class IndexedTriangles(Triangles):
    """Triangles of vertices (v, 3) and faces (m, 3) of indices, every used vertex finite."""

    vertices: Corners
    faces: Indices

    @property
    def count(self) -> int:
        return len(self.faces)

    def blocks(self, rows: int = BLOCK) -> Iterator[Corners]:
        for start in range(0, self.count, rows):
            yield self.vertices[self.faces[start : start + rows]]


def checked(blocks: Iterable[Corners], name: str) -> Iterator[Corners]:
    """Yield the blocks of a mesh; `check_finite` of each."""
    first = 0
    for block in blocks:
        check_finite(block, first, name)
        first += len(block)
        yield block


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


def not_finite(face: int, corner: Corners, name: str) -> MeshError:
    """Return the error of a face, counted from 0, that has this corner."""
    place = ", ".join(f"{value:g}" for value in corner)
    return MeshError(f"face {face + 1} has a corner at ({place})", remedy="coordinates must be finite", file=name)


@dataclass(frozen=True, eq=False)
class ScaledTriangles(Triangles):
    """The given triangles with each coordinate times its factor.

    Of a mirror image the corners are read backwards, so that what was wound outwards still is.
    """

    given: Triangles
    factors: Floats

    @property
    def count(self) -> int:
        return self.given.count

    def blocks(self, rows: int = BLOCK) -> Iterator[Corners]:
        return map(self._stretched, self.given.blocks(rows))

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
    labels = {**triangles.labels, "scale": triangles.scale * common}
    return ScaledTriangles(given=triangles, factors=given / common, **labels)


def polygon_triangles(
    name: str,
    vertices: Corners,
    corners: Indices,
    sizes: Indices,
    *,
    significand: int,
    scale: float,
    notes: tuple[str, ...],
) -> IndexedTriangles:
    """Return the triangles of polygons, those of more than three corners fanned from their first one.

    A fan has the boundary of its polygon and, where that is plane, the same integrals, even if it is not convex.

    Args:
        vertices: (v, 3). corners: (sum of sizes,) indices into them, one polygon after the other.
        sizes: (k,) corners of each polygon.

    Raises:
        MeshError: there are none, one has fewer than three corners, or a corner does not exist or is not finite.
    """
    if not len(sizes):
        what = f"holds {len(vertices)} vertices and no faces" if len(vertices) else "holds no vertices and no faces"
        raise MeshError(what, remedy="export a mesh of triangles", file=name)
    small = sizes < 3
    if small.any():
        face = int(small.argmax())
        what = f"face {face + 1} has {sizes[face]} corners"
        raise MeshError(what, remedy="a face needs three; leave it out", file=name)
    _check_corners(name, vertices, corners, sizes)
    if len(vertices) < 1 << 31:
        corners = corners.astype(np.int32, copy=False)
    larger = int((sizes > 3).sum())
    faces = _fans(corners, sizes) if larger else corners.reshape(-1, 3)
    if larger:
        notes = (*notes, f"{larger} of {len(sizes)} faces have more than three corners: cut into triangles")
    return IndexedTriangles(name, vertices, faces, significand=significand, scale=scale, notes=notes)


def _check_corners(name: str, vertices: Corners, corners: Indices, sizes: Indices) -> None:
    outside = (corners < 0) | (corners >= len(vertices))
    if outside.any():
        at = int(outside.argmax())
        what = f"face {_face_of(at, sizes) + 1} names vertex {corners[at]}, counted from 0, of {len(vertices)}"
        raise MeshError(what, remedy="the file is cut short or damaged: export it again", file=name)
    finite = np.logical_and.reduce(np.isfinite(vertices), axis=1)
    if not finite.all():
        used = np.logical_not(finite[corners])
        if used.any():
            at = int(used.argmax())
            raise not_finite(_face_of(at, sizes), vertices[corners[at]], name)


def _face_of(corner: int, sizes: Indices) -> int:
    return int(np.searchsorted(np.cumsum(sizes), corner, side="right"))


def _fans(corners: Indices, sizes: Indices) -> Indices:
    """(m, 3) of the corners first, k, k + 1 of each polygon, k from 1 to its size - 2."""
    firsts = np.cumsum(sizes) - sizes
    counts = sizes - 2
    first = np.repeat(firsts, counts)
    second = first + 1 + np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.stack([corners[first], corners[second], corners[second + 1]], axis=1)
