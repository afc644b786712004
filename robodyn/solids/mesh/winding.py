"""Winding numbers of open surfaces."""

from __future__ import annotations

from math import pi

import numpy as np

from robodyn.programs.vectors import product
from robodyn.solids.mesh.indexed import Indexed
from robodyn.solids.mesh.triangles import Floats

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
        depth = (normal * A).sum(axis=1) - product(x, normal.T)
        found[start : start + rows] = np.arctan2(depth, a * b * c + apart / 2).sum(axis=1)
    return found / (2 * pi)
