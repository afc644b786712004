"""The finite groups of rotations and reflections of space, and bodies that have their symmetry and no more."""

from __future__ import annotations

from math import pi

import numpy as np
from scipy.spatial import ConvexHull

from robodyn.programs.vectors import rotation_about

GOLDEN = (1 + 5**0.5) / 2
X, Z = np.eye(3)[0], np.eye(3)[2]
INVERSION, FLAT, UPRIGHT = -np.eye(3), np.diag((1.0, 1.0, -1.0)), np.diag((1.0, -1.0, 1.0))


def _turn(axis, fold):
    axis = np.asarray(axis, dtype=float)
    return rotation_about(axis / np.linalg.norm(axis), 2 * pi / fold)


def _generators(name: str, n: int) -> list[np.ndarray]:
    third, half = _turn((1, 1, 1), 3), _turn(X, 2)
    return {
        "C": [_turn(Z, n)],
        "Cv": [_turn(Z, n), UPRIGHT],
        "Ch": [_turn(Z, n), FLAT],
        "D": [_turn(Z, n), half],
        "Dh": [_turn(Z, n), half, FLAT],
        "Dd": [FLAT @ _turn(Z, 2 * n), half],
        "S": [FLAT @ _turn(Z, 2 * n)],
        "T": [_turn(Z, 2), third],
        "Td": [FLAT @ _turn(Z, 4), third],
        "Th": [_turn(Z, 2), third, INVERSION],
        "O": [_turn(Z, 4), third],
        "Oh": [_turn(Z, 4), third, INVERSION],
        "I": [_turn((0, 1, GOLDEN), 5), third],
        "Ih": [_turn((0, 1, GOLDEN), 5), third, INVERSION],
    }[name]


def group(name: str, n: int = 1) -> list[np.ndarray]:
    """All elements, (3, 3) orthogonal."""
    found = [np.eye(3)]
    for element in found:
        for generator in _generators(name, n):
            product = generator @ element
            if not any(np.allclose(product, other, atol=1e-9) for other in found):
                found.append(product)
    return found


def planes(elements: list[np.ndarray]) -> list[np.ndarray]:
    """Normals of the mirror planes."""
    mirrors = [Q for Q in elements if np.linalg.det(Q) < 0 and abs(np.trace(Q) - 1) < 1e-9]
    return [np.linalg.eigh(Q)[1][:, 0] for Q in mirrors]


def axes(elements: list[np.ndarray]) -> list[tuple[np.ndarray, int]]:
    """Directions of the axes, with the fold of each."""
    found: list[tuple[np.ndarray, int]] = []
    lines: list[np.ndarray] = []
    turns = [Q for Q in elements if np.linalg.det(Q) > 0 and np.trace(Q) < 3 - 1e-9]
    for Q in turns:
        values, vectors = np.linalg.eig(Q)
        lines.append(np.real(vectors[:, np.argmin(np.abs(values - 1))]))
    for line in lines:
        if not any(abs(line @ other) > 1 - 1e-9 for other, _ in found):
            found.append((line, 1 + sum(abs(line @ other) > 1 - 1e-9 for other in lines)))
    return found


def body(elements: list[np.ndarray], noise: float = 0.0, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Corners (m, 3, 3) of the hull of two orbits of points, each moved by noise, in any orientation; and that."""
    rng = np.random.default_rng(seed)
    points = np.concatenate([[Q @ np.array(p) for Q in elements] for p in ((0.75, 0.3, 0.62), (0.9, -0.28, -0.25))])
    return hulled(points + noise * rng.normal(size=points.shape), rng)


def hulled(points: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Corners (m, 3, 3) of the hull of points in a random orientation; and that."""
    R, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    points = points @ R.T
    hull = ConvexHull(points)
    corners = points[hull.simplices]
    outward = np.linalg.det(corners - points.mean(axis=0)) > 0
    corners[~outward] = corners[~outward][:, ::-1]
    return corners, R
