"""Mirror planes, axes of symmetry and what they say about products of inertia."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from math import pi

import numpy as np

from robodyn.programs.vectors import length, product, rotation_about
from robodyn.solids.inertia.laws import exact, fraction
from robodyn.solids.inertia.properties import MassProperties
from robodyn.solids.mesh.asymmetry import GOLDEN_TURN, CentredBody, mirror
from robodyn.solids.mesh.columns import frame_along
from robodyn.solids.mesh.symmetry_search import Product, Search, Symmetry
from robodyn.support.floats import einsum
from robodyn.support.linear import eigen

_FIXED = 1e-2
"""How far a map may move what it leaves as it is, and what counts as no direction of its own: errors of normals."""


def symmetry(body: CentredBody, tolerance: float = 1e-6) -> Symmetry:
    """Planes and axes of symmetry of a body, with the asymmetry vol(A xor A') / 2V of each, A' the image of A.

    Verdicts: "exact" for no more than the tolerance, "within tessellation" for no more than twice what facets may have
    left out (`CentredBody.facets`), "near" for no more than 0.01. The three planes normal to principal axes are listed
    whatever their verdict, where these axes are distinct; all others if they are near. Of an axis of fold above 8 only
    planes are listed that its rotations do not carry into each other, and of an axis of revolution those that take all
    triangles to each other, or else two. So it is with twofold axes normal to an axis of fold above 8; to one of
    revolution none is listed.

    Accuracy: the asymmetry is exact along 4096 columns, and a feature between them is seen by the moments: it is not
        below |integral of f dV| / (V max|f|), for products f of up to four coordinates that change sign with the map.
        Fewer than 1 % of verdicts are wrong on bodies whose symmetry is known.
    """
    search = Search(body, tolerance, *eigen(body.S))
    axes = search.axes()
    planes = search.planes(axes)
    accepted = [mirror(plane.normal) for plane in planes if plane.holds]
    for axis in axes:
        if axis.holds:  # for second moments all folds above 2 are the same
            accepted.append(rotation_about(axis.direction, pi if axis.fold == 2 else GOLDEN_TURN))
    worst = max((each.asymmetry for each in (*planes, *axes) if each.holds), default=0.0)
    invariants = np.eye(9).reshape(-1, 3, 3)  # a basis of the matrices S = Q S Q^T for all maps Q of the body to itself
    if accepted:
        mean = sum(np.kron(Q, Q) + np.kron(Q, Q).T for Q in accepted) / (2 * len(accepted))
        values, rows = eigen(mean + 2 * np.eye(9))  # what all leave as it is has 3, and all others less
        moved = 2 * len(accepted) * (3.0 - values)  # the sum over the maps of |Q S Q^T - S|^2 for |S| = 1
        invariants = np.asarray(rows[moved < _FIXED**2]).reshape(-1, 3, 3)
    products = []
    for i, j in combinations(range(3), 2):
        free = length(invariants[:, i, j] + invariants[:, j, i]) / 2
        size, residual = float(np.sqrt(abs(body.S[i, i] * body.S[j, j]))), float(body.S[i, j])
        relative = residual / size if size else 0.0
        products.append(Product("xyz"[i] + "xyz"[j], residual, relative, free <= max(tolerance, 2 * worst)))
    return Symmetry(planes, axes, tuple(products), invariants)


def symmetrized(body: MassProperties, found: Symmetry) -> MassProperties:
    """Return the average of a body and of its images under all accepted planes and axes [m], and their products.

    The centre of mass goes to the nearest place that all of them keep, S_c + m d d^T to the nearest matrix that they
    all keep (their average, as they are orthogonal), d being the way of the centre; products that are 0 by symmetry are
    set to 0. Mass, volume and area stay as they are.
    """
    normals = [(plane.normal, plane.offset) for plane in found.planes if plane.holds]
    for axis in found.axes:
        normals += [(across, product(across, axis.point)) for across in frame_along(axis.direction)[:2] if axis.holds]
    shift = np.zeros(3)
    if normals:
        N = np.array([normal for normal, _ in normals])
        off = einsum("ki,i->k", N, body.com) - [offset for _, offset in normals]
        values, rows = eigen(einsum("ki,kj->ij", N, N))
        there = rows[values > _FIXED**2 * values[0]]
        shift = np.asarray(einsum("mi,mj,kj,k->i", there / values[: len(there), None], there, N, off))
    S = body.S_exact + fraction(body.mass) * np.outer(exact(shift), exact(shift))
    rows = found.invariants.reshape(-1, 9)
    flat = S.astype(float).ravel()
    change = (flat - einsum("ki,kj,j->i", rows, rows, flat)).reshape(3, 3)
    S = S - exact((change + change.T) / 2)
    for one in found.products:
        if one.zero:
            i, j = ("xyz".index(name) for name in one.axes)
            S[i, j] = S[j, i] = fraction(0.0)
    return replace(body, com=body.com - shift, S_c=S, S_low=np.zeros((3, 3)))
