"""Closed meshes as arrays (m, 3, 3) float64 of corners, wound outwards; centred on the origin unless said.

Every function returns a new array. Corners that several triangles share have the same bits in each of them, so the
meshes are closed exactly. Compose with `moved`, `flipped` and `np.concatenate`.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def corners(vertices: ArrayLike, faces: ArrayLike) -> Floats:
    """(m, 3, 3) from vertices (v, 3) and triangles (m, 3) of indices."""
    return np.asarray(vertices, dtype=np.float64)[np.asarray(faces)]


def box(sizes: ArrayLike = (1.0, 1.0, 1.0)) -> Floats:
    """12 triangles; `sizes` along x, y, z. Volume: their product."""
    signs = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners(np.array(signs) * np.asarray(sizes), _fanned(quads))


def tetrahedron(vertices: ArrayLike = ((0, 0, 0), (5, 0, 0), (0, 4, 0), (0, 0, 3))) -> Floats:
    """4 triangles of the tetrahedron with these vertices, wound outwards whatever their order.

    The default has volume 10, centre (1.25, 1, 0.75), and about the centre at density 1 the inertia
    [[9.375, 2.5, 1.875], [2.5, 12.75, 1.5], [1.875, 1.5, 15.375]] (Mirtich 1996).
    """
    points = np.asarray(vertices, dtype=np.float64)
    found = corners(points, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
    return found if np.linalg.det(points[1:] - points[0]) > 0 else flipped(found)


def uv_sphere(radius: float = 1.0, rings: int = 16, sectors: int = 32) -> Floats:
    """A sphere of `rings` bands of latitude: 2 sectors (rings - 1) triangles."""
    latitude = np.pi * np.arange(1, rings) / rings
    profile = np.stack([np.sin(latitude), np.cos(latitude)], axis=1) * radius
    return _revolved(profile, sectors, top=radius, bottom=-radius)


def cylinder(radius: float = 1.0, height: float = 2.0, sectors: int = 32) -> Floats:
    """A prism about z on a regular polygon inscribed in the circle: 4 sectors triangles.

    Volume: sectors / 2 sin(2 pi / sectors) radius^2 height.
    """
    half = height / 2
    return _revolved(np.array([(radius, half), (radius, -half)]), sectors, top=half, bottom=-half)


def cone(radius: float = 1.0, height: float = 2.0, sectors: int = 32) -> Floats:
    """A pyramid about z, its base at z = 0, on a regular polygon inscribed in the circle: 2 sectors triangles."""
    return _revolved(np.array([(radius, 0.0)]), sectors, top=height, bottom=0.0)


def torus(major: float = 2.0, minor: float = 0.5, rings: int = 32, sectors: int = 16) -> Floats:
    """A torus about z: `rings` sections of `sectors` corners each, 2 rings sectors triangles."""
    u, v = _angles(rings)[:, None], _angles(sectors)
    reach = major + minor * np.cos(v)
    points = np.stack(np.broadcast_arrays(reach * np.cos(u), reach * np.sin(u), minor * np.sin(v)), axis=-1)
    index = np.arange(rings * sectors).reshape(rings, sectors)
    right, up = np.roll(index, -1, axis=0), np.roll(index, -1, axis=1)
    both = np.roll(right, -1, axis=1)
    quads = np.stack([index, right, both, up], axis=-1).reshape(-1, 4)
    return corners(points.reshape(-1, 3), _fanned(quads))


def sheet(width: float = 1.0, depth: float = 1.0) -> Floats:
    """Two triangles in the plane z = 0: an open surface."""
    x, y = width / 2, depth / 2
    return corners([(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)], [(0, 1, 2), (0, 2, 3)])


def moved(triangles: Floats, offset: ArrayLike = (0.0, 0.0, 0.0), R: ArrayLike | None = None) -> Floats:
    """Every corner x at R x + offset; shared corners keep equal bits."""
    turned = triangles if R is None else np.einsum("ij,mkj->mki", np.asarray(R, dtype=np.float64), triangles)
    return turned + np.asarray(offset, dtype=np.float64)


def flipped(triangles: Floats) -> Floats:
    """The same triangles, wound the other way."""
    return triangles[:, ::-1].copy()


def binary_stl(triangles: ArrayLike, header: bytes = b"", extra: bytes = b"", count: int | None = None) -> bytes:
    """A binary STL file: normals zero, corners rounded to float32, `count` in the header if the true one is not wanted.

    Args:
        header: at most 80 bytes. extra: bytes that follow the triangles.
    """
    values = np.asarray(triangles, dtype=np.float32)
    records = np.zeros(len(values), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    records["corners"] = values
    number = len(values) if count is None else count
    return header.ljust(80, b"\0") + number.to_bytes(4, "little") + records.tobytes() + extra


def _angles(count: int) -> Floats:
    return 2 * np.pi * np.arange(count) / count


def _fanned(polygons: ArrayLike) -> NDArray[np.int64]:
    """(m, 3) triangles from the first corner of each polygon of (k, n) indices."""
    index = np.asarray(polygons, dtype=np.int64)
    fans = [index[:, [0, i, i + 1]] for i in range(1, index.shape[1] - 1)]
    return np.stack(fans, axis=1).reshape(-1, 3)


def _revolved(profile: Floats, sectors: int, top: float, bottom: float) -> Floats:
    """A body of revolution about z: poles at `top` and `bottom`, between them circles of (radius, height) downwards."""
    angle = _angles(sectors)
    circles = [np.stack([r * np.cos(angle), r * np.sin(angle), np.full(sectors, z)], axis=1) for r, z in profile]
    points = np.concatenate([np.array([(0, 0, top), (0, 0, bottom)]), *circles])
    rows = [2 + sectors * k + np.arange(sectors) for k in range(len(profile))]
    first, last = rows[0], rows[-1]
    faces = [np.stack([np.zeros_like(first), first, np.roll(first, -1)], axis=1)]
    faces += [_fanned(np.stack([a, b, np.roll(b, -1), np.roll(a, -1)], axis=1)) for a, b in pairwise(rows)]
    faces += [np.stack([np.ones_like(last), np.roll(last, -1), last], axis=1)]
    return corners(points, np.concatenate(faces))
