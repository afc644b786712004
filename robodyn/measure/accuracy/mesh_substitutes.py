"""Moments of other surfaces in place of the given one: its hull, or one with fewer triangles; and what unions take."""

from __future__ import annotations

from typing import Any

import numpy as np

from robodyn.errors import MeshError
from robodyn.programs.vectors import length
from robodyn.solids.mesh.exact import Moments
from robodyn.solids.mesh.indexed import merged
from robodyn.solids.mesh.integrate import integrate
from robodyn.solids.mesh.triangles import Floats, MemoryTriangles
from robodyn.solids.mesh.union import manifold


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
    """The body united with itself moved by a fifth of its box: what uniting bodies of this size takes.

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
    """The integral over a closed surface."""
    found = integrate(MemoryTriangles("surface", np.ascontiguousarray(corners)))
    r, V = found.reference, found.volume
    first = found.first + V * r
    mixed = np.outer(found.first, r)
    return Moments(V, first, found.S + mixed + mixed.T + V * np.outer(r, r))
