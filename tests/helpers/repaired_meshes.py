"""Meshes after their repair, and what the tests ask of them."""

from __future__ import annotations

import numpy as np

from robodyn.solids.mesh.closed import fingerprint
from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.repair import repair
from robodyn.solids.mesh.triangles import MemoryTriangles

R = np.linalg.qr(np.array([(1.0, 2.0, 3.0), (-2.0, 1.0, 0.5), (0.3, 0.7, -1.0)]))[0]
"""A rotation about no axis in particular."""


def repaired(*parts, cavities=False):
    """The repair of these triangles (m, 3, 3) taken together."""
    return repair(MemoryTriangles("part", np.concatenate(parts)), cavities)


def taken(found):
    """(name, count) of every step."""
    return [(step.name, step.count) for step in found.steps]


def enclosed(triangles):
    """The signed volume of triangles as they are."""
    return integrate(MemoryTriangles("part", triangles)).volume


def volume(found):
    """What a repaired surface encloses; it must be closed."""
    assert fingerprint(found.triangles).closed
    return integrate(found.triangles).volume
