"""Curves of straight lines and arcs in a plane: profiles and outlines of parts."""

from __future__ import annotations

from itertools import pairwise
from math import ceil, pi

import numpy as np

Loop = list[tuple]
"""Pieces of a curve: ("line", start, end) or ("arc", centre, radius, from angle, to angle)."""


def line(start: tuple, end: tuple) -> tuple:
    return ("line", np.asarray(start, float), np.asarray(end, float))


def arc(centre: tuple, radius: float, start: float, end: float) -> tuple:
    return ("arc", np.asarray(centre, float), radius, np.radians(start), np.radians(end))


def point(piece: tuple, t: float) -> np.ndarray:
    if piece[0] == "line":
        return piece[1] + t * (piece[2] - piece[1])
    angle = piece[3] + t * (piece[4] - piece[3])
    return piece[1] + piece[2] * np.array((np.cos(angle), np.sin(angle)))


def polygon(points: list) -> Loop:
    return [line(a, b) for a, b in pairwise([*points, points[0]])]


def ring(points: list, closed: bool = True) -> Loop:
    """Straight lines from point to point, and back to the first if closed."""
    return polygon(points) if closed else [line(a, b) for a, b in pairwise(points)]


def circle(centre: tuple, radius: float) -> Loop:
    return [arc(centre, radius, 0, 360)]


def hole(centre: tuple, radius: float) -> Loop:
    return [arc(centre, radius, 0, -360)]


def quadrature(loop: Loop) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points x, y along a curve, and dy with weights, for integrals that are exact to rounding."""
    u, w = np.polynomial.legendre.leggauss(60)
    t, w = (u + 1) / 2, w / 2
    x, y, dy = [], [], []
    for piece in loop:
        points = np.array([point(piece, s) for s in t])
        x.append(points[:, 0])
        y.append(points[:, 1])
        rate = piece[2][1] - piece[1][1] if piece[0] == "line" else (points[:, 0] - piece[1][0]) * (piece[4] - piece[3])
        dy.append(w * rate)
    return np.concatenate(x), np.concatenate(y), np.concatenate(dy)


def rounded_disc(radius: float, height: float, r: float) -> Loop:
    h, R = height / 2, radius - r
    low, high = arc((R, -h + r), r, -90, 0), arc((R, h - r), r, 0, 90)
    return [line((0, -h), (R, -h)), low, line((radius, -h + r), (radius, h - r)), high, line((R, h), (0, h))]


def pulley_top() -> Loop:
    return ring([(2, 0.8), (2, 1), (0.5, 1), (0.5, -1)], False)


def rounded_rectangle(width: float, depth: float, r: float) -> Loop:
    x, y = width / 2 - r, depth / 2 - r
    corners = [(x, -y, -90), (x, y, 0), (-x, y, 90), (-x, -y, 180)]
    arcs = [arc((a, b), r, start, start + 90) for a, b, start in corners]
    ends = [(point(arc, 0.0), point(arc, 1.0)) for arc in arcs]
    lines = [line(ends[i][1], ends[(i + 1) % 4][0]) for i in range(4)]
    return [piece for pair in zip(arcs, lines, strict=True) for piece in pair]


def bracket() -> Loop:
    """An L with a fillet within and a rounded heel without."""
    return [
        arc((0.8, 0.8), 0.8, 180, 270),
        *ring([(0.8, 0), (3, 0), (3, 1), (1.4, 1)], False),
        arc((1.4, 1.4), 0.4, 270, 180),
        *ring([(1, 1.4), (1, 3), (0, 3), (0, 0.8)], False),
    ]


def lever() -> Loop:
    """A large and a small eye joined by their common tangents."""
    lean = np.degrees(np.arccos(0.6 / 4))
    arcs = arc((0, 0), 1.0, lean, 360 - lean), arc((4, 0), 0.4, -lean, lean)
    return [
        arcs[0],
        line(point(arcs[0], 1), point(arcs[1], 0)),
        arcs[1],
        line(point(arcs[1], 1), point(arcs[0], 0)),
    ]


def corners_of(loop: Loop, facets: int) -> np.ndarray:
    """(n, 2) points along a curve, the last one left out; arcs in facets of at most a turn over so many."""
    points = []
    for piece in loop:
        count = 1 if piece[0] == "line" else ceil(abs(piece[4] - piece[3]) / (2 * pi) * facets - 1e-9)
        points += [point(piece, k / count) for k in range(count)]
    return np.array(points)
