"""Ways to find the moments of a solid, from the crudest to the exact one, and how many operations they take."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from robodyn.errors import MeshError
from robodyn.programs.vectors import Array, length, product
from robodyn.solids.inertia.laws import exact
from robodyn.solids.mesh.columns import Lattice, Pieces, directions, pieces
from robodyn.solids.mesh.indexed import merged
from robodyn.solids.mesh.inside import manifold, winding_numbers
from robodyn.solids.mesh.integrals import Moments, integrate, swept
from robodyn.solids.mesh.kernel import symmetric, volume_kernel
from robodyn.solids.mesh.triangles import CHUNK, MemoryTriangles, Triangles, workspace
from robodyn.support.floats import Floats

_TESTS = 1 << 18
"""Tests of a point against a triangle that are made at once."""


def by_box(corners: Floats) -> Moments:
    """Of the box around the corners (m, 3, 3)."""
    lo, hi = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    size, middle = hi - lo, lo / 2 + hi / 2
    volume = size[0] * size[1] * size[2]
    return Moments(volume, volume * middle, volume * (np.outer(middle, middle) + np.diag(size * size / 12)))


def by_columns(corners: Floats, count: int) -> Moments:
    """By about so many columns along one direction, exact in depth."""
    lattice = Lattice.over(corners, directions()[0], count=count)
    return _of_matrix(_inside(corners, lattice).moments(lattice))


def by_voxels(corners: Floats, count: int) -> Moments:
    """By cubes on about so many columns; a cube counts where its centre is inside."""
    lattice = Lattice.over(corners, directions()[0], count=count)
    inside, step = _inside(corners, lattice), lattice.step
    first = np.ceil(inside.start / step - 0.5).astype(np.int64)
    counts = np.maximum(np.ceil(inside.stop / step - 0.5).astype(np.int64) - first, 0)
    which = np.repeat(np.arange(len(counts)), counts)
    height = first[which] + np.arange(len(which)) - (np.cumsum(counts) - counts)[which] + 0.5
    places = lattice.places(inside.column[which])
    points = np.stack([*places, height * step, np.ones(len(which))])
    frame = np.eye(4)
    frame[:3, :3] = lattice.frame
    return _of_matrix(step**3 * product(frame.T, product(points, points.T), frame))


def by_chance(corners: Floats, count: int) -> Moments:
    """By so many random points in the box; one counts where a ray from it leaves the body once more than it enters."""
    points, size = _random_points(corners, count)
    rows = max(_TESTS // len(corners), 1)
    within = np.concatenate([_winding(points[k : k + rows], corners) > 0 for k in range(0, count, rows)])
    return _of_points(points[within], size, count)


def by_winding_numbers(corners: Floats, count: int) -> Moments:
    """By so many random points in the box; one counts where the surface goes around it, by its solid angle."""
    points, size = _random_points(corners, count)
    return _of_points(points[winding_numbers(points, merged(corners)) > 0.5], size, count)


def _random_points(corners: Floats, count: int) -> tuple[Floats, Floats]:
    """Return random points in the box around the corners, and its size."""
    lo, hi = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    return lo + (hi - lo) * np.random.default_rng(0).random((count, 3)), hi - lo


def by_triangles(triangles: Triangles, dtype: type, reference: Floats) -> Moments:
    """The integral over the surface in floats of this type, about a point of reference; nan where it overflows."""
    sweep = swept(triangles, volume_kernel, dtype=dtype, reference=reference.astype(dtype))
    if not np.isfinite(sweep.sums[:, :10]).all():
        return Moments(np.nan, np.full(3, np.nan), np.full((3, 3), np.nan))
    sums = sweep.totals(slice(10))
    return Moments(sums[0] / 6, sums[1:4] / 24, symmetric(sums[4:10] / 120))


def inertia(moments: Moments) -> Array:
    """Return (3, 3) fractions, about the centre of mass at density 1, without any rounding of their own."""
    V, first, S = (exact(part) if isinstance(part, np.ndarray) else exact(part).item() for part in moments)
    about = S - np.outer(first, first) / V
    turned: Array = np.eye(3, dtype=int) * about.trace() - about
    return turned


def _inside(corners: Floats, lattice: Lattice) -> Pieces:
    every = pieces(lattice.hits(corners))
    found = every.of(every.weight > 0)
    return found._replace(weight=np.ones(len(found.column)))


def _of_points(inside: Floats, size: Floats, count: int) -> Moments:
    """By the points inside of so many in a box."""
    Y = np.concatenate([inside, np.ones((len(inside), 1))], axis=1)
    return _of_matrix(product(Y.T, Y) * (size[0] * size[1] * size[2] / count))


def _of_matrix(matrix: Floats) -> Moments:
    """Of the integral (4, 4) of y y^T with y = (x, 1)."""
    return Moments(matrix[3, 3], matrix[:3, 3], matrix[:3, :3])


def _winding(points: Floats, corners: Floats) -> Floats:
    """Return how often the surface goes around each point: crossings of a ray along z, with their signs."""
    X = corners - 0.0
    a, b, c = X[:, 0], X[:, 1], X[:, 2]
    p = points[:, None]
    left = [_turn(p, start, end) for start, end in ((a, b), (b, c), (c, a))]
    area = left[0] + left[1] + left[2]
    up = (left[0] >= 0) & (left[1] >= 0) & (left[2] >= 0) & (area > 0)
    down = (left[0] < 0) & (left[1] < 0) & (left[2] < 0)
    met = up | down
    with np.errstate(all="ignore"):
        height = (left[1] * a[:, 2] + left[2] * b[:, 2] + left[0] * c[:, 2]) / area
    above = met & (height > p[..., 2])
    found: Floats = (above & up).sum(axis=1) - (above & down).sum(axis=1)
    return found


def _turn(p: Floats, start: Floats, end: Floats) -> Floats:
    """Twice the area that a point makes with an edge, seen along z."""
    turned: Floats = (end[:, 0] - start[:, 0]) * (p[..., 1] - start[:, 1]) - (end[:, 1] - start[:, 1]) * (
        p[..., 0] - start[:, 0]
    )
    return turned


def by_hull(corners: Floats) -> Moments:
    """Of the convex hull.

    Raises:
        scipy.spatial.QhullError: the corners lie in a plane.
    """
    from scipy.spatial import ConvexHull

    hull = ConvexHull(corners.reshape(-1, 3))
    faces = hull.points[hull.simplices]
    normals = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    inwards = (normals * hull.equations[:, :3]).sum(axis=1) < 0
    faces[inwards] = faces[inwards, ::-1]
    return _about_origin(faces)


def by_decimation(corners: Floats, tolerance: float) -> Moments:
    """Of the body with fewer triangles, none of which is farther off than this share of the box's diagonal.

    Raises:
        MeshError: the surface is no manifold.
    """
    solid = _manifold(corners)
    away = tolerance * length(np.ptp(corners, axis=(0, 1)))
    mesh = solid.simplify(away).to_mesh64()
    return _about_origin(mesh.vert_properties[:, :3][mesh.tri_verts])


def union_with_a_copy(corners: Floats) -> Any:
    """Return the body united with itself moved by a fifth of its box: what uniting bodies of this size takes.

    Raises:
        MeshError: the surface is no manifold.
    """
    from manifold3d import Manifold, OpType

    solid = _manifold(corners)
    moved = solid.translate(tuple(np.ptp(corners, axis=(0, 1)) / 5))
    return Manifold.batch_boolean([solid, moved], OpType.Add).volume()


def _manifold(corners: Floats) -> Any:
    mesh = merged(corners)
    solid = manifold(mesh.vertices, mesh.faces)
    if solid is None or not hasattr(solid, "simplify"):
        raise MeshError("the surface is no manifold" if solid is None else "manifold3d is older than 3.1")
    return solid


def _about_origin(corners: Floats) -> Moments:
    """Return the integral over a closed surface."""
    found = integrate(MemoryTriangles("surface", np.ascontiguousarray(corners)))
    r, V = found.reference, found.volume
    first = found.first + V * r
    mixed = np.outer(found.first, r)
    return Moments(V, first, found.S + mixed + mixed.T + V * np.outer(r, r))


_RECENTRING = 9
"""Subtractions that take the three corners of a triangle to the point of reference."""


def counted(act: Callable[[Array], object], numbers: Array) -> int:
    """Element operations of NumPy's functions that an act does on an array and on what comes of it.

    A matrix product counts its multiplications and additions; sorting, indexing and running sums count nothing.
    """
    total = 0

    class Counted(np.ndarray):  # type: ignore[type-arg,unused-ignore]
        __array_priority__ = 1.0

        def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
            nonlocal total
            plain = [_plain(value) for value in inputs]
            if "out" in options:
                options["out"] = tuple(_plain(value) for value in options["out"])
            result = getattr(ufunc, method)(*plain, **options)
            if ufunc is np.matmul:
                total += 2 * np.size(result) * plain[0].shape[-1]
            else:
                total += max(np.size(value) for value in (*plain, *_several(result)))
            several = _several(result)
            wrapped = tuple(each.view(Counted) if isinstance(each, np.ndarray) else each for each in several)
            return wrapped if isinstance(result, tuple) else wrapped[0]

    act(numbers.view(Counted))
    return total


def integral_operations(triangles: int) -> int:
    """Of the exact integral over so many triangles, in floats of any width."""
    kernel = volume_kernel(workspace(12, CHUNK).reshape(4, 3, CHUNK))
    total = 0
    for function, arguments in kernel.steps:
        if function is np.matmul:
            total += 2 * arguments[0].size
        elif function == np.add.reduce:
            total += arguments[0].size
        elif function is not np.copyto:
            total += arguments[-1].size
    return triangles * (_RECENTRING + round(total / CHUNK))


def _plain(value: Any) -> Any:
    return np.asarray(value) if isinstance(value, np.ndarray) else value


def _several(result: Any) -> tuple[Any, ...]:
    return result if isinstance(result, tuple) else (result,)
