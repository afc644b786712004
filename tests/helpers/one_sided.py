"""Closed surfaces with one side only: no winding, no inside."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from helpers.mesh_oracle import rotation
from helpers.tessellations import open_quads, quads, quartered

Floats = np.ndarray


def klein_bottle(around: int = 40, across: int = 24) -> Floats:
    """A figure of eight that turns over on its way around; it cuts itself, but every edge has two triangles."""
    u, v = np.meshgrid(2 * np.pi * np.arange(around) / around, 2 * np.pi * np.arange(across) / across, indexing="ij")
    grid = _figure_of_eight(u, v)
    return quads(np.concatenate([grid, grid[:1, -np.arange(across) % across]]))


def _figure_of_eight(u: Floats, v: Floats) -> Floats:
    reach = 2 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
    rise = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
    return np.stack([reach * np.cos(u), reach * np.sin(u), rise], axis=-1)


def boy(p: Floats) -> Floats:
    """Apery's immersion of the projective plane, of points of the sphere."""
    x, y, z = p.T
    one = (2 * x**2 - y**2 - z**2) / 2 + y * z * (y**2 - z**2) / 2
    one += (z * x * (x**2 - z**2) + x * y * (y**2 - x**2)) / 2
    other = np.sqrt(3) / 2 * (y**2 - z**2 + z * x * (z**2 - x**2) + x * y * (y**2 - x**2))
    return np.stack([one, other, (x + y + z) * ((x + y + z) ** 3 + 4 * (y - x) * (z - y) * (x - z))], axis=1)


def projective(image: Callable[[Floats], Floats]) -> Floats:
    """The image, the same for opposite points, of half a sphere, turned so that no edge lies where it cuts itself."""
    half = np.array([((s, 0, 0), (0, t, 0), (0, 0, 1)) for s, t in ((1, 1), (-1, 1), (-1, -1), (1, -1))], float)
    for _ in range(4):
        half = quartered(half)
    points = half.reshape(-1, 3).round(12) + 0.0
    lead = np.where(points[:, 2] != 0, points[:, 2], np.where(points[:, 1] != 0, points[:, 1], points[:, 0]))
    points = np.where(lead < 0, -1, 1)[:, None] * points
    return image(points @ rotation(3).T).round(12).reshape(-1, 3, 3) + 0.0


def seamed(around: int = 60, across: int = 32) -> Floats:
    """The Klein bottle with its seams computed twice, so that they meet but for rounding."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, around + 1), np.linspace(0, 2 * np.pi, across + 1), indexing="ij")
    return open_quads(_figure_of_eight(u, v))


SURFACES = {
    "Klein bottle with a seam": seamed(),
    "Klein bottle with a seam in single precision": seamed().astype(np.float32).astype(float),
    "Klein bottle": klein_bottle(),
    "Klein bottle of odd counts": klein_bottle(41, 25),
    "Klein bottle without a face": klein_bottle()[1:],
    "Boy": projective(boy),
}
