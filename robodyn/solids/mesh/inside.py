"""Whether points lie inside a surface, and the faults of shells that points inside of others show."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product as product_of
from math import pi
from typing import Any

import numpy as np

from robodyn.solids.mesh.indexed import Indexed, Mask, Numbers, components, hashed, in_parts, triple
from robodyn.solids.mesh.triangles import Triangles
from robodyn.support.floats import Floats

_PAIRS = 1 << 17
"""Points times triangles of a block: its intermediate results stay in the cache."""


def winding_numbers(points: Floats, mesh: Indexed) -> Floats:
    """(n,) solid angle of a surface as seen from points (n, 3), over 4 pi: 1 within a closed surface wound outwards.

    The sum over triangles of 2 atan2(det(a, b, c), abc + (a.b) c + (b.c) a + (c.a) b), with a, b, c from the point to
    the corners (van Oosterom, Strackee 1983); of open surfaces the generalized winding number (Jacobson 2013).

    Accuracy: 1e-12 where no triangle is nearer than 1e-6 of its size.
    """
    found = np.zeros(len(points))
    used, faces = np.unique(mesh.faces, return_inverse=True)
    vertices, faces = mesh.vertices[used], faces.reshape(-1, 3)
    A, B, C = vertices[faces].transpose(1, 0, 2)
    normal = np.cross(B - A, C - A)
    sides = [((p - q) ** 2).sum(axis=1) for p, q in ((A, B), (B, C), (C, A))]
    rows = max(_PAIRS // max(len(faces), 1), 1)
    for start in range(0, len(points), rows):
        x = points[start : start + rows]
        square = ((vertices - x[:, None]) ** 2).sum(axis=2)
        a2, b2, c2 = square[:, faces.T].transpose(1, 0, 2)
        a, b, c = np.sqrt(square)[:, faces.T].transpose(1, 0, 2)
        apart = (a2 + b2 - sides[0]) * c + (b2 + c2 - sides[1]) * a + (c2 + a2 - sides[2]) * b
        depth = (normal * A).sum(axis=1) - x @ normal.T
        found[start : start + rows] = np.arctan2(depth, a * b * c + apart / 2).sum(axis=1)
    return found / (2 * pi)


_DIRECTIONS = ((0.3183098861, 0.5772156649), (-0.4142135623, 0.2236067977), (0.1414213562, -0.6931471805))
"""Slopes of rays, generic so that they meet neither corners nor edges of parts drawn along the axes."""

_ROUNDING = 16 * np.finfo(np.float64).eps


class Interior:
    """The inside of a closed surface of triangles (n, 3, 3): where its winding number is not zero."""

    def __init__(self, corners: Floats) -> None:
        self._corners = corners
        self._sheared = [_Sheared(corners, slope) for slope in _DIRECTIONS[:1]]

    def has(self, point: Floats) -> bool | None:
        """Return whether it has this point (3,); None where rounding cannot tell the point from the surface."""
        for k, slope in enumerate(_DIRECTIONS):
            if k == len(self._sheared):
                self._sheared.append(_Sheared(self._corners, slope))
            winding = self._sheared[k].winding(point)
            if winding is not None:
                return winding != 0
        return None


class OpenInterior:
    """The inside of an open surface, wound either way: where its winding number is above 1/2."""

    def __init__(self, mesh: Indexed) -> None:
        self._mesh = mesh

    def has(self, point: Floats) -> bool:
        """Return whether it has this point (3,)."""
        return bool(abs(winding_numbers(point[None], self._mesh)[0]) > 0.5)


class _Sheared:
    """Triangles in coordinates in which the rays of one slope go up along the last axis.

    A corner that triangles share is rounded alike in all of them: the surface stays closed.
    """

    def __init__(self, corners: Floats, slope: tuple[float, float]) -> None:
        self._slope = np.array([*slope, 0.0])
        self._corners = self._of(corners)
        self._lo, self._hi = self._corners.min(axis=1)[:, :2].T.copy(), self._corners.max(axis=1).T.copy()

    def _of(self, points: Floats) -> Floats:
        sheared: Floats = points - self._slope * points[..., 2:]
        return sheared

    def winding(self, point: Floats) -> int | None:
        """RankChanges of the ray up from a point, upwards less downwards; None if it meets an edge within rounding."""
        u, v, w = p = self._of(point)
        (left, front), (right, back, top) = self._lo, self._hi
        near = (left <= u) & (u <= right) & (front <= v) & (v <= back) & (top >= w)
        corners = self._corners[near] - p
        (x, y, z), size = corners.transpose(2, 1, 0), np.abs(corners).max(axis=(1, 2))
        margin = _ROUNDING * (np.abs(p).max() + size)
        first, second = x[[1, 2, 0]] * y[[2, 0, 1]], x[[2, 0, 1]] * y[[1, 2, 0]]
        weight = first - second
        if (np.abs(weight) <= margin * size).any(axis=0)[_straddles(weight, margin * size)].any():
            return None
        hit = (weight > 0).all(axis=0) | (weight < 0).all(axis=0)
        height = (weight * z)[:, hit].sum(axis=0)
        side = np.sign(weight[0, hit])
        if (np.abs(height) <= 3 * margin[hit] * np.abs(weight[:, hit]).sum(axis=0)).any():
            return None
        return int(side[height * side > 0].sum())


def _straddles(weight: Floats, margin: Floats) -> Mask:
    """Triangles that a ray may meet: no weight is certainly against another."""
    above, below = (weight > margin).any(axis=0), (weight < -margin).any(axis=0)
    either: Mask = np.logical_not(above & below)
    return either


def manifold(vertices: Floats, faces: Numbers) -> Any:
    """Return a body for manifold3d, None if it is no manifold."""
    from manifold3d import Error, Manifold, Mesh64

    found = Manifold(Mesh64(vertices, faces.astype(np.uint64)))
    return found if found.status() == Error.NoError else None


def solid(shell: Indexed) -> Any:
    """Return what a shell encloses, however it is wound, for manifold3d; None if it is no manifold."""
    used, faces = np.unique(shell.faces, return_inverse=True)
    faces, vertices = faces.reshape(-1, 3), shell.vertices[used]
    return manifold(vertices, faces if shell.volume(vertices[0]) > 0 else faces[:, ::-1])


def triangle_boxes(corners: Floats) -> Floats:
    """(2, n, 3) least and largest coordinates of triangles (n, 3, 3)."""
    return np.stack([corners.min(axis=1), corners.max(axis=1)])


_MOST_PAIRS = 2_000_000
_CELLS = 64


def may_cross(one: Floats, other: Floats) -> bool:
    """Return whether triangles with these boxes (2, n, 3) may meet; True where that is not told.

    Boxes are compared in pairs or, where they are many and small, by the cells of a lattice that they touch.
    """
    lo = np.maximum(one[0].min(axis=0), other[0].min(axis=0))
    hi = np.minimum(one[1].max(axis=0), other[1].max(axis=0))
    one, other = (boxes[:, ((boxes[0] <= hi) & (boxes[1] >= lo)).all(axis=1)] for boxes in (one, other))
    if not one.shape[1] or not other.shape[1]:
        return False
    if one.shape[1] * other.shape[1] <= _MOST_PAIRS:
        return any(bool(((one[0] <= top) & (one[1] >= low)).all(axis=1).any()) for low, top in zip(*other, strict=True))
    step = np.maximum(hi - lo, np.finfo(float).tiny) / _CELLS
    cells = [np.clip((boxes - lo) / step, 0, _CELLS - 1).astype(np.int64) for boxes in (one, other)]
    if max(int((last - first).max()) for first, last in cells) > 2:
        return True
    touched = [_cells_of(*each) for each in cells]
    return bool((touched[0] & touched[1]).any())


def _cells_of(first: Numbers, last: Numbers) -> Mask:
    """Return which cells are touched by boxes from these cells (n, 3) on to those, at most two further."""
    found = np.zeros(_CELLS**3, np.bool_)
    for steps in product_of(range(3), repeat=3):
        x, y, z = np.minimum(first + np.array(steps), last).T
        found[(x * _CELLS + y) * _CELLS + z] = True
    return found


_TRIED_PAIRS = 16
"""Pairs of shells that are tried for what they share."""
_BODIES = 16
"""Bodies in which an inward shell may be a cavity; where more are around it, it is not judged."""
_POINTS = 16
"""Points of a shell that are tried."""
_FLAT = 1e-9
"""Volume over that of the box below which a shell has no inside."""
_DEEP = 1e-4
"""How far into another shell's box a point must lie, over its size, to be tried."""


def shell_faults(triangles: Triangles) -> tuple[int, bool]:
    """Return how many shells are wound inwards without being cavities, and whether two wound outwards share volume.

    Shells are the components of triangles that share corners. One that is wound inwards is a cavity if it lies in one
    wound outwards; two wound outwards of which one has points within the other count what they share twice. A few
    points of each shell are tried, and of many shells only the pairs that share most of their boxes: what is found is
    there, but shells that hardly meet may be missed.

    Args:
        triangles: a closed surface.
    """
    shells = _Shells.of(triangles.array())
    solid = np.abs(shells.volumes) > _FLAT * np.prod(shells.hi - shells.lo, axis=1)
    bodies, inward = solid & (shells.volumes > 0), np.flatnonzero(solid & (shells.volumes < 0))
    inside = _Interiors(shells)
    inverted = sum(not _may_be_cavity(shells, inside, int(one), bodies) for one in inward)
    return inverted, any(inside.overlap(one, body, inward) for one, body in _pairs(shells, bodies))


@dataclass(frozen=True, eq=False)
class _Shells:
    """Triangles (m, 3, 3) of each shell, their volumes (k,), and the corners (k, 3) of their boxes."""

    corners: list[Floats]
    volumes: Floats
    lo: Floats
    hi: Floats

    @classmethod
    def of(cls, corners: Floats) -> _Shells:
        parts, lo, hi = in_parts(corners, _labels(corners))
        volumes = np.array([float(triple(part - part[0, 0]).sum()) / 6 for part in parts])
        return cls(parts, volumes, lo, hi)

    def shared(self, body: int, others: Mask) -> Floats:
        """(k,) volume that the boxes of other shells share with that of a body."""
        common = np.minimum(self.hi, self.hi[body]) - np.maximum(self.lo, self.lo[body])
        volume: Floats = np.where((common > 0).all(axis=1) & others, np.prod(common, axis=1), 0.0)
        volume[body] = 0.0
        return volume


class _Interiors:
    """The insides of bodies, each made when it is first asked for."""

    def __init__(self, shells: _Shells) -> None:
        self._shells = shells
        self._known: dict[int, Interior] = {}

    def reaching(self, one: int, body: int) -> Iterator[Floats]:
        """Points (3,) of a shell that lie in a body."""
        for point in _points(self._shells.corners[one], self._shells.lo[body], self._shells.hi[body]):
            if self._has(body, point):
                yield point

    def overlap(self, one: int, body: int, inward: Numbers) -> bool:
        """Return whether a body has points in another, outside the cavities among these shells."""
        cavities = [int(shell) for shell in inward]
        return any(not any(self._has(shell, point) for shell in cavities) for point in self.reaching(one, body))

    def _has(self, shell: int, point: Floats) -> bool:
        if not ((self._shells.lo[shell] < point) & (point < self._shells.hi[shell])).all():
            return False
        if shell not in self._known:
            self._known[shell] = Interior(self._shells.corners[shell])
        return bool(self._known[shell].has(point))


def _may_be_cavity(shells: _Shells, inside: _Interiors, one: int, bodies: Mask) -> bool:
    around = np.flatnonzero(shells.shared(one, bodies))
    if len(around) > _BODIES:
        return True
    return any(True for body in around for _ in inside.reaching(one, int(body)))


def _pairs(shells: _Shells, bodies: Mask) -> list[tuple[int, int]]:
    """Bodies and others whose boxes share volume, those that share most of the first first."""
    size = np.prod(shells.hi - shells.lo, axis=1)
    shares = []
    for body in np.flatnonzero(bodies):
        volume = shells.shared(int(body), bodies)
        shares += [(-volume[one] / size[one], int(one), int(body)) for one in np.flatnonzero(volume)]
    return [(one, body) for _, one, body in sorted(shares)[:_TRIED_PAIRS]]


def _points(shell: Floats, lo: Floats, hi: Floats) -> Floats:
    """Corners and centres of triangles and of their sides, well within a box, those of the largest triangles."""
    a, b, c = shell.transpose(1, 0, 2)
    margin = _DEEP * (hi - lo)
    points = np.concatenate([(a + b + c) / 3, (a + b) / 2, (b + c) / 2, (c + a) / 2, a, b, c])
    near = np.flatnonzero(((points > lo + margin) & (points < hi - margin)).all(axis=1))
    if len(near) > _POINTS:
        rows = near % len(shell)
        area = (np.cross(b[rows] - a[rows], c[rows] - a[rows]) ** 2).sum(axis=1)
        near = near[np.lexsort((-area, near // len(shell)))[:_POINTS]]
    chosen: Floats = points[near]
    return chosen


def _labels(corners: Floats) -> Numbers:
    """(m,) the shell of each triangle."""
    _, number = np.unique(hashed(corners.transpose(1, 2, 0)), return_inverse=True)
    one, two, three = number.reshape(3, -1)
    return components(int(number.max()) + 1, np.concatenate([one, one]), np.concatenate([two, three]))[one]
