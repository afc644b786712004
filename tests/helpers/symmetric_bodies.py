"""Bodies with known symmetry and asymmetry, as corners (m, 3, 3)."""

from __future__ import annotations

import numpy as np

from helpers import mesh_samples as samples
from robodyn.solids.mesh.asymmetry import CentredBody
from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.read.load import from_array
from robodyn.solids.mesh.symmetry import symmetry


def found(corners, **options):
    triangles = from_array(corners)
    return symmetry(CentredBody.of(triangles, integrate(triangles)), **options)


def verdicts(things):
    return [thing.verdict for thing in things]


def bracket(height=1.5):
    """An L of arms 3 and 2 long and 1 wide: symmetric in the plane z = 0, and in no other."""
    return extrusion([(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (0, 2)], height, hub=(0.5, 0.5))


def pinwheel():
    """Three equal sails about z, leaning to one side, between z = -0.5 and 0.5."""
    angle = 2 * np.pi * np.arange(12) / 12
    radius = np.tile([2.0, 1.7, 1.2, 1.0], 3)
    return extrusion(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]), 1.0)


def extrusion(outline, height, hub=(0.0, 0.0)):
    """A prism, centred in z, on a polygon of which every corner is seen from the hub."""
    base = np.asarray(outline, dtype=float)
    n = len(base)
    ring = [np.column_stack([base, np.full(n, z)]) for z in (-height / 2, height / 2)]
    points = np.concatenate([*ring, [(*hub, -height / 2), (*hub, height / 2)]])
    i = np.arange(n)
    j = (i + 1) % n
    low, high = np.full(n, 2 * n), np.full(n, 2 * n + 1)
    faces = [(low, j, i), (high, n + i, n + j), (i, j, n + j), (i, n + j, n + i)]
    return samples.corners(points, np.concatenate([np.column_stack(face) for face in faces]))


def cavity(centre, sizes):
    """The walls of a box-shaped hole."""
    return samples.moved(samples.flipped(samples.box(sizes)), centre)
