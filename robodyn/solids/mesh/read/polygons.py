"""Polygons of vertex indices -> triangles, and to how many bits the numbers of a text are rounded."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.lines import Integers, Tokens, runs
from robodyn.solids.mesh.read.source import Source
from robodyn.solids.mesh.triangles import Corners, IndexedTriangles, not_finite
from robodyn.support.floats import Floats

_SAMPLE, _MOST = 64, 1024
_FEW, _FLOAT32, _FLOAT64 = 5, 9, 16


def add_sample(words: list[bytes], tokens: Tokens, index: Integers) -> None:
    """Some of these words, evenly spread, until there are enough."""
    if len(words) < _MOST:
        step = max(1, index.size // _SAMPLE)
        words += [tokens.word(int(i)) for i in index.reshape(-1)[::step]]


def significand(words: Sequence[bytes]) -> int:
    """Bits of the numbers that these words are, from the most digits that one of them has, zeros at its ends left out.

    Numbers of fewer than 5 digits are taken as exact, as in a box drawn by hand: 53. Up to 9 digits are what programs
    write for float32: at most 24.
    """
    most = max((_digits(word) for word in words), default=0)
    if most < _FEW or most >= _FLOAT64:
        return 53
    bits = math.floor(most * math.log2(10.0))
    return min(bits, 24) if most <= _FLOAT32 else min(bits, 53)


def _digits(word: bytes) -> int:
    mantissa = word.lower().partition(b"e")[0].lstrip(b"+-")
    return len(mantissa.replace(b".", b"").strip(b"0"))


class Polygons:
    """Vertices and polygons of a text, taken part by part."""

    def __init__(self) -> None:
        self._vertices: list[Floats] = [np.empty((0, 3))]
        self._corners: list[Integers] = [np.empty(0, np.int64)]
        self._sizes: list[Integers] = [np.empty(0, np.int64)]
        self._words: list[bytes] = []
        self.points = self.faces = 0

    def add_vertices(self, words: Tokens, first: Integers) -> None:
        """Take three coordinates from each of these words on."""
        if len(first):
            index = first[:, None] + np.arange(3)
            add_sample(self._words, words, index)
            self._vertices.append(words.floats(index.reshape(-1)).reshape(-1, 3))
            self.points += len(first)

    def add_faces(self, corners: Integers, sizes: Integers) -> None:
        """Take polygons of so many corners each, given as numbers of vertices from 0 on."""
        self._corners.append(corners)
        self._sizes.append(sizes)
        self.faces += len(sizes)

    def triangles(self, source: Source, scale: float, notes: tuple[str, ...]) -> IndexedTriangles:
        """Return all of them, cut into triangles; see `triangles_of`."""
        return triangles_of(
            source.name,
            np.concatenate(self._vertices),
            np.concatenate(self._corners),
            np.concatenate(self._sizes),
            significand=significand(self._words),
            scale=scale,
            notes=notes,
        )


def triangles_of(
    name: str,
    vertices: Corners,
    corners: Integers,
    sizes: Integers,
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
    _check_sizes(name, sizes)
    _check_corners(name, vertices, corners, sizes)
    if len(vertices) < 1 << 31:
        corners = corners.astype(np.int32, copy=False)
    larger = int((sizes > 3).sum())
    faces = _fans(corners, sizes) if larger else corners.reshape(-1, 3)
    if larger:
        notes = (*notes, f"{larger} of {len(sizes)} faces have more than three corners: cut into triangles")
    return IndexedTriangles(name, vertices, faces, significand=significand, scale=scale, notes=notes)


def _check_sizes(name: str, sizes: Integers) -> None:
    small = sizes < 3
    if small.any():
        face = int(small.argmax())
        what = f"face {face + 1} has {sizes[face]} corners"
        raise MeshError(what, remedy="a face needs three; leave it out", file=name)


def _check_corners(name: str, vertices: Corners, corners: Integers, sizes: Integers) -> None:
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


def _face_of(corner: int, sizes: Integers) -> int:
    return int(np.searchsorted(np.cumsum(sizes), corner, side="right"))


def _fans(corners: Integers, sizes: Integers) -> NDArray[np.signedinteger[Any]]:
    """(m, 3) of the corners first, k, k + 1 of each polygon, k from 1 to its size - 2."""
    firsts = np.cumsum(sizes) - sizes
    counts = sizes - 2
    first = np.repeat(firsts, counts)
    second = runs(firsts + 1, counts)
    return np.stack([corners[first], corners[second], corners[second + 1]], axis=1)
