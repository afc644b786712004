"""Bodies with known symmetry and asymmetry, as corners (m, 3, 3), and the finite groups of space."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from helpers import mesh_samples as samples
from helpers.tessellations import hull
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


def group(name, n=1):
    """All elements of a finite group of rotations and reflections, (3, 3) orthogonal, by Schoenflies' names."""
    flat, upright = np.diag((1.0, 1.0, -1.0)), np.diag((1.0, -1.0, 1.0))
    turns, improper = {
        "C": (f"C{n}", None),
        "Cv": (f"C{n}", upright),
        "Ch": (f"C{n}", flat),
        "D": (f"D{n}", None),
        "Dh": (f"D{n}", flat),
        "Dd": (f"D{n}", _turn_and_mirror(2 * n)),
        "S": (f"C{n}", _turn_and_mirror(2 * n)),
        "T": ("T", None),
        "Td": ("T", _turn_and_mirror(4)),
        "Th": ("T", -np.eye(3)),
        "O": ("O", None),
        "Oh": ("O", -np.eye(3)),
        "I": ("I", None),
        "Ih": ("I", -np.eye(3)),
    }[name]
    proper = list(Rotation.create_group(turns).as_matrix())
    return proper if improper is None else proper + [improper @ Q for Q in proper]


def _turn_and_mirror(fold):
    return np.diag((1.0, 1.0, -1.0)) @ Rotation.from_rotvec((0, 0, 2 * np.pi / fold)).as_matrix()


def planes(elements):
    """Normals of the mirror planes."""
    mirrors = [Q for Q in elements if np.linalg.det(Q) < 0 and abs(np.trace(Q) - 1) < 1e-9]
    return [np.linalg.eigh(Q)[1][:, 0] for Q in mirrors]


def axes(elements):
    """Directions of the axes, with the fold of each."""
    turns = [Rotation.from_matrix(Q).as_rotvec() for Q in elements if np.linalg.det(Q) > 0 and np.trace(Q) < 3 - 1e-9]
    lines = [turn / np.linalg.norm(turn) for turn in turns]
    axes = []
    for line in lines:
        if not any(abs(line @ other) > 1 - 1e-9 for other, _ in axes):
            axes.append((line, 1 + sum(abs(line @ other) > 1 - 1e-9 for other in lines)))
    return axes


def body(elements, noise=0.0, seed=0):
    """Corners (m, 3, 3) of the hull of two orbits of points, each moved by noise, in any orientation; and that."""
    rng = np.random.default_rng(seed)
    points = np.concatenate([[Q @ np.array(p) for Q in elements] for p in ((0.75, 0.3, 0.62), (0.9, -0.28, -0.25))])
    points = points + noise * rng.normal(size=points.shape)
    R, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    middle = points.mean(axis=0)
    return hull((points - middle) @ R.T) + R @ middle, R
