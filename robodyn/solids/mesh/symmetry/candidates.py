"""Where a body may have planes and axes of symmetry, by its moments."""

from __future__ import annotations

from math import atan2, gcd, inf

import numpy as np

from robodyn.programs.vectors import Array, length, product
from robodyn.solids.mesh.symmetry.higher_moments import EvenForm
from robodyn.support.floats import Floats, first_largest
from robodyn.support.sums import einsum

DISTINCT = 1e-9
"""Principal second moments that are closer than this part of the largest leave their axes open."""

CLOSE = 0.1
"""Those that are closer than this part may be equal but for facets, or but for an asymmetry that is near."""

_LEVELS = (1e-10, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2, 3e-2)
_STARTS, _STEPS = 256, 24
_STEEP = 1e-6
_RIM = 1e-6
_MOST = 64


def folds(axial: Array) -> list[float]:
    """Folds that an axis may have, the largest first, infinite for revolution.

    An axis of fold n leaves only the moments whose frequency is a multiple of n: n is the greatest common divisor of
    the frequencies of those above a level of noise, for several levels.
    """
    size = np.abs(axial).max(axis=1)
    found = {gcd(*(int(m) + 1 for m in np.flatnonzero(size > level))) or inf for level in _LEVELS}
    return sorted(found - {1}, reverse=True)


def mirror_angles(axial: Array) -> list[float]:
    """Angles about the axis of the half planes in which a mirror plane through it may lie.

    Seen from such an angle all moments are real: it is the phase of the strongest one, over its frequency.
    """
    frequency, phase, _ = _strongest(axial)
    return [(phase + np.pi * j) / frequency for j in range(frequency)]


def half_turn_angles(axial: Array) -> list[float]:
    """Angles about the axis of the directions normal to it about which half a turn may be a symmetry.

    Seen from such an angle the moments with an even power of z are real, and those with an odd power imaginary.
    """
    frequency, phase, power = _strongest(axial)
    return [(phase + np.pi * (j - power / 2)) / frequency for j in range(frequency)]


def _strongest(axial: Array) -> tuple[int, float, int]:
    """Frequency, phase and power of z of the largest moment; frequency 0 of none."""
    size = np.abs(axial)
    m, k = (int(place) for place in np.unravel_index(first_largest(size), size.shape))
    found = complex(axial[m, k])
    return (m + 1, atan2(found.imag, found.real), k) if size[m, k] > _LEVELS[0] else (0, 0.0, 0)


def rim_angles(points: Array, frame: Array) -> Floats:
    """The angles about the axis, ascending, of the points (n, 3) that are farthest from it; a symmetry permutes them.

    Args:
        frame: (3, 3) rows: two directions from the axis on, and its own.
    """
    x, y = einsum("ij,nj->in", frame[:2], points)
    radius = np.hypot(x, y)
    outer = radius >= radius.max() * (1 - _RIM)
    return distinct_angles(np.array([atan2(b, a) for a, b in zip(x[outer].tolist(), y[outer].tolist(), strict=True)]))


def rim_folds(count: int) -> list[float]:
    """Return the folds of an axis with so many points on its rim: divisors, the largest first."""
    return [float(n) for n in range(count, 1, -1) if count % n == 0][:4]


def distinct_angles(angles: Array) -> Floats:
    """Each angle once, within a millionth of a turn, ascending from that of the least."""
    ordered = np.sort(angles)
    apart = np.diff(ordered, append=ordered[0] + 2 * np.pi) > 2 * np.pi * _RIM
    found: Floats = ordered[apart]
    return found


def critical_directions(form: EvenForm) -> Floats:
    """(n, 3) isolated critical points, one of each opposite pair, of a form among unit vectors.

    Every normal of a mirror plane and every axis is one, wherever the form tells directions apart: one of degree 4 for
    the symmetry of a cube, one of degree 6 for that of an icosahedron. Newton's method from many directions.
    """
    n = _spread(_STARTS)
    for _ in range(_STEPS):
        step, _ = _newton(form, n)
        size = np.linalg.norm(step, axis=1, keepdims=True)
        n = n + step * np.minimum(1.0, 0.3 / np.maximum(size, 1e-300))
        n = n / np.linalg.norm(n, axis=1, keepdims=True)
    step, steep = _newton(form, n)
    return distinct_lines(n[(np.linalg.norm(step, axis=1) < 1e-9) & (steep > _STEEP * np.abs(form.factors).max())])


def distinct_lines(directions: Array) -> Floats:
    """(n, 3) each direction once, whatever its sign, within 1e-6."""
    kept: list[Array] = []
    for direction in directions:
        if all(length(np.cross(direction, other)) > 1e-6 for other in kept):
            kept.append(direction)
    return np.array(kept).reshape(-1, 3)


def swapping_normals(points: Array) -> Floats:
    """(n, 3) normals of the planes through the origin that swap one of the farthest points (n, 3) with the others."""
    radius = np.linalg.norm(points, axis=1)
    far = points[radius >= radius.max() * (1 - _RIM)]
    between = far[0] - far
    length = np.linalg.norm(between, axis=1)
    apart = length > _RIM * radius.max()
    return distinct_lines((between[apart] / length[apart, None])[:_MOST])


def _newton(form: EvenForm, n: Array) -> tuple[Array, Array]:
    """Newton's steps (n, 3) in the tangent planes, and the least absolute curvature (n,) there."""
    gradient, hessian = form.derivatives(n)
    slope = einsum("ni,ni->n", gradient, n)
    across = np.cross(n, np.eye(3)[np.argmin(np.abs(n), axis=1)])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    tangent = np.stack((across, np.cross(n, across)), axis=2)
    curvature = product(tangent.transpose(0, 2, 1), hessian - slope[:, None, None] * np.eye(3), tangent)
    values, turned = _plane_eigen(curvature)
    axes, size = product(tangent, turned), np.abs(curvature).max() + 1e-300
    safe = np.where(np.abs(values) > 1e-14 * size, values, size)
    step = -einsum("nij,nj->ni", axes, einsum("nij,ni->nj", axes, gradient) / safe)
    return step, np.abs(values).min(axis=1)


def _spread(count: int) -> Floats:
    """Directions spread over half a sphere (Fibonacci), and the coordinate axes."""
    index = np.arange(count) + 0.5
    z, turn = index / count, np.pi * (1 + 5**0.5) * index
    r = np.sqrt(1 - z * z)
    return np.concatenate([np.eye(3), np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)])


def _plane_eigen(A: Array) -> tuple[Array, Array]:
    """Eigenvalues (n, 2) and orthonormal eigenvectors (n, 2, 2), as columns, of symmetric matrices (n, 2, 2)."""
    half, off = (A[:, 0, 0] - A[:, 1, 1]) / 2, A[:, 0, 1]
    radius = np.copysign(np.sqrt(half * half + off * off), half)
    x, y = half + radius, off
    size = np.sqrt(x * x + y * y)
    x, y = np.where(size > 0, (x, y), [[1.0], [0.0]]) / np.where(size > 0, size, 1.0)
    middle = (A[:, 0, 0] + A[:, 1, 1]) / 2
    values = np.stack((middle + radius, middle - radius), axis=1)
    return values, np.stack((x, -y, y, x), axis=1).reshape(-1, 2, 2)
