"""Mirror planes, axes of symmetry and what they say about products of inertia."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from math import pi

import numpy as np

from robodyn.inertia.composite import composite
from robodyn.inertia.properties import MassProperties
from robodyn.mesh.asymmetry import GOLDEN_TURN, CentredBody, mirror
from robodyn.mesh.integrals import Integrals
from robodyn.mesh.symmetry_kinds import Axis, Plane, Product, Symmetry
from robodyn.mesh.symmetry_search import Search
from robodyn.mesh.triangles import Triangles
from robodyn.spatial import IDENTITY, ZERO, Array, rotation_about


def symmetry(triangles: Triangles, integrals: Integrals, tolerance: float = 1e-6) -> Symmetry:
    """Planes and axes of symmetry of a body, with the asymmetry vol(A xor A') / 2V of each, A' the image of A.

    Verdicts: "exact" for no more than the tolerance, "within tessellation" for no more than twice what facets may have
    left out (`facets.facet_volume`), "near" for no more than 0.01. The three planes normal to principal axes are listed
    whatever their verdict, where these axes are distinct; all others if they are near. Of an axis of fold above 8 only
    planes are listed that its rotations do not carry into each other.

    Args:
        triangles: of a closed mesh, of either winding.
        integrals: those of the same mesh.

    Raises:
        MeshError: the volume is zero.

    Accuracy: the asymmetry is exact along 4096 columns, and a feature between them is seen by the moments: it is not
        below |integral of f dV| / (V max|f|), for products f of up to four coordinates that change sign with the map.
    """
    body = CentredBody.of(triangles, integrals)
    search = Search.of(body, tolerance)
    axes = search.axes()
    planes = search.planes(axes)
    accepted = [mirror(plane.normal) for plane in planes if plane.holds]
    accepted += [_turn(axis) for axis in axes if axis.holds]
    asymmetries = [plane.asymmetry for plane in planes if plane.holds] + [axis.asymmetry for axis in axes if axis.holds]
    worst = max(asymmetries, default=0.0)
    return Symmetry(planes, axes, _products(body.S, accepted, max(tolerance, 2 * worst)))


def symmetrized(body: MassProperties, plane: Plane, scale: float = 1.0) -> MassProperties:
    """The average of a body and its mirror image: half the mass in either. Volume and area stay as they are.

    Args:
        plane: one of a mesh; for several that are normal to each other, average once for each.
        scale: metres in a unit of the mesh's file.

    Accuracy: products with the normal about the centre of mass within 2 eps of the trace of the second moments.
    """
    half = body.scaled_to_mass(body.mass / 2)
    image = mirror(plane.normal), 2 * plane.offset * scale * plane.normal
    return replace(composite(((half, (IDENTITY, ZERO)), (half, image))), volume=body.volume, area=body.area)


def _turn(axis: Axis) -> Array:
    """For second moments all folds above 2 are the same."""
    return rotation_about(axis.direction, pi if axis.fold == 2 else GOLDEN_TURN)


def _products(S: Array, maps: list[Array], slack: float) -> tuple[Product, ...]:
    """A product is 0 by symmetry where it is zero in all matrices S = Q S Q^T, for the maps Q of the body to itself."""
    fixed = np.eye(9)
    if maps:
        defects = np.concatenate([np.kron(Q, Q) - np.eye(9) for Q in maps])
        _, values, rows = np.linalg.svd(defects)
        fixed = rows[values < _FIXED]
    found = []
    for i, j in combinations(range(3), 2):
        part = fixed.reshape(-1, 3, 3)
        free = float(np.linalg.norm(part[:, i, j] + part[:, j, i])) / 2
        size = float(np.sqrt(S[i, i] * S[j, j]))
        residual = float(S[i, j])
        found.append(Product("xyz"[i] + "xyz"[j], residual, residual / size if size else 0.0, free <= slack))
    return tuple(found)


_FIXED = 1e-2
"""Singular values below this are zero but for the errors of normals and axes."""
