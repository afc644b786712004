"""Boxes, cylinders, spheres and capsules as triangles, for pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import product, rotation_from_rpy
from robodyn.robot.urdf.parts import Geometry

Floats = NDArray[np.float64]

_AROUND, _ALONG = 32, 12
"""Corners of a circle, and of a quarter and a half circle along the axis."""


def primitive(geometry: Geometry) -> Floats:
    """The surface of a shape that is no mesh, (m, 3, 3) in its link's frame [m]."""
    R, p = rotation_from_rpy(*geometry.origin.rpy), np.array(geometry.origin.xyz)
    own = _box(geometry.size) if geometry.shape == "box" else _turned(_profile(geometry.shape, geometry.size))
    found: Floats = product(own, R.T) + p
    return found


def _box(size: tuple[float, ...]) -> Floats:
    faces = []
    for k in range(3):
        for side in (-1.0, 1.0):
            u, v = side * np.eye(3)[(k + 1) % 3], np.eye(3)[(k + 2) % 3]
            a, b, c, d = (side * np.eye(3)[k] + s * u + t * v for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1)))
            faces += [(a, b, c), (a, c, d)]
    found: Floats = np.array(faces) * np.array(size) / 2
    return found


def _profile(shape: str, size: tuple[float, ...]) -> Floats:
    """(k, 2) radius and height of a surface of revolution about z, from its bottom to its top."""
    radius = size[0]
    if shape == "cylinder":
        half = size[1] / 2
        return np.array(((0.0, -half), (radius, -half), (radius, half), (0.0, half)))
    turn = np.linspace(0.0, np.pi / 2, _ALONG)
    cap = radius * np.column_stack((np.cos(turn), np.sin(turn)))
    up = np.array((0.0, size[1] / 2 if shape == "capsule" else 0.0))
    return np.concatenate((cap[::-1] * (1, -1) - up, cap + up))


def _turned(profile: Floats) -> Floats:
    """The surface that a profile sweeps."""
    turn = np.linspace(0.0, 2 * np.pi, _AROUND + 1)
    rings = np.stack([np.column_stack((r * np.cos(turn), r * np.sin(turn), np.full_like(turn, z))) for r, z in profile])
    a, b, c, d = rings[:-1, :-1], rings[:-1, 1:], rings[1:, 1:], rings[1:, :-1]
    quads = (np.stack((a, b, c), axis=2), np.stack((a, c, d), axis=2))
    return np.concatenate([each.reshape(-1, 3, 3) for each in quads])
