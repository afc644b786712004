"""Triangles of a mesh, wherever they are kept, stretched, from polygons, and in blocks that stay in the cache."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from robodyn.errors import MeshError
from robodyn.programs.vectors import Array
from robodyn.support.floats import Floats

Corners = NDArray[np.floating[Any]]
Indices = NDArray[np.signedinteger[Any]]

BLOCK = 4096
"""Triangles of a block: its corners stay in the cache."""


@dataclass(frozen=True, eq=False)
class Triangles(ABC):
    """The triangles of a mesh, all with finite corners, at least one, to be read as often as wanted.

    significand: bits to which the file rounds a coordinate (24 for float32), relative to the largest one; scale: metres
    per unit of the file; notes: what was assumed or left out; warnings: why it may not be the whole mesh.
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
        """Consecutive blocks (n, 3, 3), 1 <= n <= rows: triangle, corner, coordinate, in units of the file, read-only.
        MeshError where a corner is not finite (the face is named), or the file changed since it was opened."""

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


def checked(blocks: Iterable[Corners], name: str) -> Iterator[Corners]:
    first = 0
    for block in blocks:
        check_finite(block, first, name)
        first += len(block)
        yield block


def check_finite(block: Corners, first: int, name: str) -> None:
    """Raise MeshError, naming the first triangle with a corner that is not finite; first: how many came before."""
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
    """The given triangles with each coordinate times its factor. Of a mirror image the corners are read backwards, so
    that what was wound outwards still is."""

    given: Triangles
    factors: Floats

    @property
    def count(self) -> int:
        return self.given.count

    def blocks(self, rows: int = BLOCK) -> Iterator[Corners]:
        for corners in self.given.blocks(rows):
            stretched = corners if (self.factors == 1).all() else corners * self.factors
            yield stretched[:, ::-1] if self.factors.prod() < 0 else stretched


def scaled(triangles: Triangles, factors: Sequence[float]) -> Triangles:
    """Return the triangles stretched along x, y and z by factors (3,), negative ones for mirror images. What the
    factors have in common goes into the scale, so that a change of unit changes no coordinate."""
    given = np.array(factors, dtype=float)
    if not (np.isfinite(given) & (given != 0)).all():
        listed = " ".join(f"{factor:g}" for factor in given)
        what, remedy = f"the scale {listed} leaves no volume", "give factors that are not zero"
        raise MeshError(what, remedy=remedy, file=triangles.name)
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
) -> MemoryTriangles:
    """Return the triangles of polygons, those of more than three corners fanned from their first one.

    A fan has the boundary of its polygon and, where that is plane, the same integrals, even if it is not convex.

    Args:
        corners: (sum of sizes,) indices into the vertices (v, 3), one polygon after the other; sizes: (k,) of each.

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
    ends = np.cumsum(sizes)
    outside = (corners < 0) | (corners >= len(vertices))
    if outside.any():
        at = int(outside.argmax())
        face = int(np.searchsorted(ends, at, side="right"))
        what = f"face {face + 1} names vertex {corners[at]}, counted from 0, of {len(vertices)}"
        raise MeshError(what, remedy="the file is cut short or damaged: export it again", file=name)
    finite = np.logical_and.reduce(np.isfinite(vertices), axis=1)
    if not finite.all() and not finite[corners].all():
        at = int(finite[corners].argmin())
        raise not_finite(int(np.searchsorted(ends, at, side="right")), vertices[corners[at]], name)
    if len(vertices) < 1 << 31:
        corners = corners.astype(np.int32, copy=False)
    larger = int((sizes > 3).sum())
    if not larger:
        faces = corners.reshape(-1, 3)
    else:  # the corners first, k, k + 1 of each polygon, k from 1 to its size - 2
        counts = sizes - 2
        first = np.repeat(ends - sizes, counts)
        second = first + 1 + np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        faces = np.stack([corners[first], corners[second], corners[second + 1]], axis=1)
        notes = (*notes, f"{larger} of {len(sizes)} faces have more than three corners: cut into triangles")
    return MemoryTriangles(name, vertices[faces], significand=significand, scale=scale, notes=notes)


CHUNK = 256
"""Numbers that one dot product adds up: few, because the rounding errors of equal terms do not cancel."""
ROWS = 17 * CHUNK
"""Triangles of a block: enough to hide what a call of NumPy costs, few enough for the second-level cache."""
_BITS = 3

Step = tuple[Callable[..., Any], tuple[Any, ...]]
"""A function and its arguments: rows of workspaces, which are written to. What is ready to be called costs less."""


def workspace(rows: int, columns: int, dtype: DTypeLike = np.float64) -> Array:
    """(rows, columns) numbers that start on a cache line."""
    kind: np.dtype[Any] = np.dtype(dtype)
    size = rows * columns * kind.itemsize
    raw = np.empty(size + 64, np.uint8)
    first = -int(raw.__array_interface__["data"][0]) % 64
    return raw[first : first + size].view(kind).reshape(rows, columns)


def block_space(triangles: Triangles, dtype: DTypeLike = np.float64) -> Array:
    """(4, 3 coordinates, n): three corners of each triangle of a block, and as many rows to spare."""
    n = min(max(-(-triangles.count // CHUNK), 1) * CHUNK, ROWS)
    return workspace(12, n, dtype).reshape(4, 3, n)


def fill(space: Array, triangles: Triangles, checked: bool = True) -> Iterator[Array]:
    """Put one block after the other into the same space, which may be written to in between: (3 corners, 3, n) of it.
    Where triangles do not fill it the rest is one corner of the mesh three times over: a triangle that adds nothing to
    any sum, box or boundary. Not `checked`, which is faster, if the caller sees for itself that corners are finite."""
    X = space[:3]
    as_given = X.transpose(2, 0, 1)
    rows = X.shape[-1]
    for block in (triangles.blocks if checked else triangles.records)(rows):
        as_given[: len(block)] = block
        X[:, :, len(block) :] = X[:1, :, :1]
        yield X


def reference_in(X: Array) -> Array:
    """The centre (3,) of the box of a block (3 corners, 3, n), in few bits, so that subtracting it is mostly exact."""
    lo, hi = X.min(axis=(0, 2)), X.max(axis=(0, 2))
    with np.errstate(all="ignore"):
        _, exponent = np.frexp(hi - lo)
        quantum = np.ldexp(1.0, exponent - _BITS)
        centre = np.rint((lo / 2 + hi / 2) / quantum) * quantum
    inside = (lo < centre) & (centre < hi)
    reference: Array = np.where(inside, centre, lo).astype(np.float64) + 0.0
    return reference
