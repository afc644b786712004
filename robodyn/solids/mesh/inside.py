"""Whether points lie inside a surface, and the faults of shells that points inside of others show."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import product as product_of
from math import pi
from typing import Any

import numpy as np

from robodyn.solids.mesh.indexed import Indexed, Numbers, components, hashed, in_parts, triple
from robodyn.solids.mesh.triangles import Triangles
from robodyn.support.floats import Floats

_PAIRS = 1 << 17
"""Points times triangles of a block: its intermediate results stay in the cache."""
_DIRECTIONS = ((0.3183098861, 0.5772156649), (-0.4142135623, 0.2236067977), (0.1414213562, -0.6931471805))
"""Slopes of rays, generic so that they meet neither corners nor edges of parts drawn along the axes."""
_ROUNDING = 16 * np.finfo(np.float64).eps
_MOST_PAIRS = 2_000_000
_CELLS = 64


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


class _Sheared:
    """Triangles in coordinates in which the rays of one slope go up along the last axis. A corner that triangles share
    is rounded alike in all of them: the surface stays closed."""

    def __init__(self, corners: Floats, slope: tuple[float, float]) -> None:
        self._slope = np.array([*slope, 0.0])
        self._corners = self._of(corners)
        self._lo, self._hi = self._corners.min(axis=1)[:, :2].T.copy(), self._corners.max(axis=1).T.copy()

    def _of(self, points: Floats) -> Floats:
        sheared: Floats = points - self._slope * points[..., 2:]
        return sheared

    def winding(self, point: Floats) -> int | None:
        """Crossings of the ray up from a point, upwards less downwards; None if it meets an edge within rounding."""
        u, v, w = p = self._of(point)
        (left, front), (right, back, top) = self._lo, self._hi
        near = (left <= u) & (u <= right) & (front <= v) & (v <= back) & (top >= w)
        corners = self._corners[near] - p
        (x, y, z), size = corners.transpose(2, 1, 0), np.abs(corners).max(axis=(1, 2))
        margin = _ROUNDING * (np.abs(p).max() + size)
        first, second = x[[1, 2, 0]] * y[[2, 0, 1]], x[[2, 0, 1]] * y[[1, 2, 0]]
        weight = first - second
        doubt = margin * size
        outside = (weight > doubt).any(axis=0) & (weight < -doubt).any(axis=0)
        if ((np.abs(weight) <= doubt).any(axis=0) & ~outside).any():
            return None
        hit = (weight > 0).all(axis=0) | (weight < 0).all(axis=0)
        height = (weight * z)[:, hit].sum(axis=0)
        side = np.sign(weight[0, hit])
        if (np.abs(height) <= 3 * margin[hit] * np.abs(weight[:, hit]).sum(axis=0)).any():
            return None
        return int(side[height * side > 0].sum())


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


def may_cross(one: Floats, other: Floats) -> bool:
    """Return whether triangles with these boxes (2, n, 3) may meet; True where that is not told. Boxes are compared in
    pairs or, where they are many and small, by the cells of a lattice that they touch."""
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
    touched = np.zeros((2, _CELLS**3), np.bool_)
    for which, (first, last) in enumerate(cells):
        for steps in product_of(range(3), repeat=3):
            x, y, z = np.minimum(first + np.array(steps), last).T
            touched[which, (x * _CELLS + y) * _CELLS + z] = True
    return bool(touched.all(axis=0).any())


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
    """Return how many shells of a closed surface are wound inwards and no cavities, and whether bodies share volume.

    Shells are the components of triangles that share corners. One that is wound inwards is a cavity if it lies in one
    wound outwards; two wound outwards of which one has points within the other count what they share twice. A few
    points of each shell are tried, and of many shells only the pairs that share most of their boxes: what is found is
    there, but shells that hardly meet may be missed.
    """
    corners = triangles.array()
    _, number = np.unique(hashed(corners.transpose(1, 2, 0)), return_inverse=True)
    one, two, three = number.reshape(3, -1)
    links = np.concatenate([one, one]), np.concatenate([two, three])
    shells, lo, hi = in_parts(corners, components(int(number.max()) + 1, *links)[one])
    volumes = np.array([float(triple(shell - shell[0, 0]).sum()) / 6 for shell in shells])
    size = np.prod(hi - lo, axis=1)
    solid = np.abs(volumes) > _FLAT * size
    bodies, inward = solid & (volumes > 0), np.flatnonzero(solid & (volumes < 0)).tolist()
    interior = cache(lambda shell: Interior(shells[shell]))

    def has(shell: int, point: Floats) -> bool:
        return bool(((lo[shell] < point) & (point < hi[shell])).all() and interior(shell).has(point))

    def reaching(shell: int, body: int) -> Iterator[Floats]:
        return (point for point in _points(shells[shell], lo[body], hi[body]) if has(body, point))

    def shared(shell: int) -> Floats:
        """(k,) volume that the boxes of other bodies share with that of a shell."""
        common = np.minimum(hi, hi[shell]) - np.maximum(lo, lo[shell])
        volume: Floats = np.where((common > 0).all(axis=1) & bodies, np.prod(common, axis=1), 0.0)
        volume[shell] = 0.0
        return volume

    inverted = 0
    for shell in inward:
        around = np.flatnonzero(shared(shell)).tolist()
        inverted += len(around) <= _BODIES and not any(True for body in around for _ in reaching(shell, body))
    shares = []
    for body in np.flatnonzero(bodies).tolist():
        volume = shared(body)
        shares += [(-volume[k] / size[k], k, body) for k in np.flatnonzero(volume).tolist()]
    tried = (reaching(shell, body) for _, shell, body in sorted(shares)[:_TRIED_PAIRS])
    return inverted, any(not any(has(cavity, point) for cavity in inward) for points in tried for point in points)


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
