"""Random stances of points on feet and polygons."""

from __future__ import annotations

import numpy as np

from robodyn.dynamics.contacts.diagnosis import base_columns
from robodyn.dynamics.contacts.problem import Problem

LENGTH = 0.3


def stance(
    seed: int, samples: int, points: int, push: float = 1.0, mass: float = 30.0, friction: float = 0.6
) -> Problem:
    """Points below a body that is pushed and turned by parts of its weight, on slopes of some 10 degrees."""
    random = np.random.default_rng(seed)
    arms = random.normal(size=(samples, points, 3)) * (0.3, 0.2, 0.05) - (0.0, 0.0, 0.5)
    normals = np.array((0.0, 0.0, 1.0)) + 0.2 * random.normal(size=(points, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    b = np.zeros((samples, 6))
    b[:, 5] = 1.0
    b += push * random.normal(size=(samples, 6)) * (0.1, 0.1, 0.1, 0.2, 0.2, 0.2)
    active = random.random((samples, points)) < 0.9
    return Problem(base_columns(arms, LENGTH), 9.81 * mass * b, normals, np.full(points, friction), active)
