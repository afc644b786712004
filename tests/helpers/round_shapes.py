"""Round solids with their exact moments: named ones, and random ones of random proportions, coarseness and pose.

Corners lie on the surface, outside of it so that facets touch it, or between; facets of arcs take 60 degrees at most.
Kinds are split: the numbers of the estimate are tuned on `TUNED`, its rules come of `TRIED` as well, and nothing comes
of `HELD_OUT`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, cos, gamma, pi

import numpy as np

from helpers import mesh_samples as samples
from helpers.mesh_oracle import rotation
from helpers.tessellations import hull, icosphere, prism, quads, rounded_corners

Floats = np.ndarray
Loop = list[tuple]
"""Pieces of a curve in a plane: ("line", start, end) or ("arc", centre, radius, from angle, to angle)."""
PLACES = {"on": 0.0, "between": 0.5, "outside": 1.0}
"""Where corners are, from on the surface to where facets touch it."""


@dataclass(frozen=True, eq=False)
class Round:
    """Triangles, and the volume, centre and second moments about it of the solid that they stand for."""

    corners: Floats
    volume: float
    com: Floats
    S: Floats

    def placed(self, rng: np.random.Generator) -> Round:
        """In any pose."""
        R, p = rotation(int(rng.integers(1 << 30))), rng.normal(size=3)
        return Round(self.corners @ R.T + p, self.volume, R @ self.com + p, R @ self.S @ R.T)


def line(start: tuple, end: tuple) -> tuple:
    return ("line", np.asarray(start, float), np.asarray(end, float))


def arc(centre: tuple, radius: float, start: float, end: float) -> tuple:
    return ("arc", np.asarray(centre, float), radius, np.radians(start), np.radians(end))


def point(piece: tuple, t: float) -> Floats:
    if piece[0] == "line":
        return piece[1] + t * (piece[2] - piece[1])
    angle = piece[3] + t * (piece[4] - piece[3])
    return piece[1] + piece[2] * np.array((np.cos(angle), np.sin(angle)))


def ring(points: list, closed: bool = True) -> Loop:
    """Straight lines from point to point, and back to the first if closed."""
    return [line(a, b) for a, b in pairwise([*points, points[0]] if closed else points)]


def hole(centre: tuple, radius: float) -> Loop:
    return [arc(centre, radius, 0, -360)]


def rounded_disc(radius: float, height: float, r: float) -> Loop:
    h, R = height / 2, radius - r
    low, high = arc((R, -h + r), r, -90, 0), arc((R, h - r), r, 0, 90)
    return [line((0, -h), (R, -h)), low, line((radius, -h + r), (radius, h - r)), high, line((R, h), (0, h))]


PULLEY = [
    *ring([(0.5, -1), (2, -1), (2, -0.8)], False),
    arc((2, 0), 0.8, -90, -270),
    *ring([(2, 0.8), (2, 1), (0.5, 1), (0.5, -1)], False),
]


def rounded_rectangle(width: float, depth: float, r: float) -> Loop:
    x, y = width / 2 - r, depth / 2 - r
    corners = [(x, -y, -90), (x, y, 0), (-x, y, 90), (-x, -y, 180)]
    arcs = [arc((a, b), r, start, start + 90) for a, b, start in corners]
    lines = [line(point(arcs[i], 1.0), point(arcs[(i + 1) % 4], 0.0)) for i in range(4)]
    return [piece for pair in zip(arcs, lines, strict=True) for piece in pair]


def lever() -> Loop:
    """A large and a small eye joined by their common tangents."""
    lean = np.degrees(np.arccos(0.6 / 4))
    large, small = arc((0, 0), 1.0, lean, 360 - lean), arc((4, 0), 0.4, -lean, lean)
    return [large, line(point(large, 1), point(small, 0)), small, line(point(small, 1), point(large, 0))]


def quadrature(loop: Loop) -> tuple[Floats, Floats, Floats]:
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


def _out(angle: float, place: float) -> float:
    """Factor on the radius of corners that are so many radians apart."""
    return 1 - place + place / cos(angle / 2)


def _corners(loop: Loop, facets: int, place: float) -> Floats:
    """(n, 2) along an open profile or around a closed one, its first point again at the end."""
    found = []
    for piece in loop:
        span = 0.0 if piece[0] == "line" else piece[4] - piece[3]
        count = max(ceil(abs(span) / (2 * pi) * facets - 1e-9), 1)
        for k in range(count + 1):
            if piece[0] == "line":
                found.append(piece[1 + k])
            else:
                angle, inner = piece[3] + k / count * span, abs(span) > 6.28 or 0 < k < count
                reach = piece[2] * (_out(span / count, place) if inner else 1.0)
                found.append(piece[1] + reach * np.array((np.cos(angle), np.sin(angle))))
    points = np.array(found)
    new = np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-9
    return points[np.append(True, new)]


def _turned(points: Floats, sectors: int, place: float) -> Floats:
    """About z; points (n, 2) of a profile upwards along the outside."""
    angle = 2 * pi * np.arange(sectors) / sectors
    reach = np.where(np.abs(points[:, 0]) < 1e-12, 0.0, points[:, 0]) * _out(2 * pi / sectors, place)
    x, y = (np.outer(reach, part) for part in (np.cos(angle), np.sin(angle)))
    return quads(np.stack([x, y, np.broadcast_to(points[:, 1:], x.shape)], axis=-1) + 0.0)


def revolved(profile: Loop, facets: int, sectors: int, place: float = 0.0) -> Round:
    """About z: the profile (r, z) goes upwards along the outside, from the axis to the axis or around."""
    x, y, dy = quadrature(profile)
    V, first, along = (pi * (x**2 * y**k) @ dy for k in range(3))
    across, z = pi / 4 * x**4 @ dy, first / V
    corners = _turned(_corners(profile, facets, place), sectors, place)
    return Round(corners, V, np.array((0, 0, z)), np.diag((across, across, along - z * first)))


def extruded(outline: Loop, holes: list[Loop], height: float, facets: int, place: float = 0.0) -> Round:
    """Along z, centred there: the outline goes counter-clockwise, the holes clockwise."""
    x, y, dy = (np.concatenate(part) for part in zip(*map(quadrature, (outline, *holes)), strict=True))
    area, cx, cy = x @ dy, x**2 / 2 @ dy, (x * y) @ dy
    xx, xy, yy = x**3 / 3 @ dy, (x**2 * y / 2) @ dy, (x * y**2) @ dy
    c, V = np.array((cx / area, cy / area, 0.0)), height * area
    S = height * np.array([(xx, xy, 0), (xy, yy, 0), (0, 0, area * height**2 / 12)])
    rings = [_corners(loop, facets, place)[:-1] for loop in (outline, *holes)]
    return Round(prism(rings, height), V, c, S - V * np.outer(c, c))


def rounded_box(inner: Floats, r: float, facets: int) -> Round:
    """All points within r of a box."""
    V, seconds = 0.0, []
    u, w = np.polynomial.legendre.leggauss(40)
    angle, w = (u + 1) * pi / 4, w * pi / 4
    for i in range(3):
        b, c = np.delete(inner, i)
        rho, x = r * np.cos(angle), inner[i] / 2 + r * np.sin(angle)
        cap = (b * c + 2 * (b + c) * rho + pi * rho**2) * rho * w
        section = b * c + 2 * (b + c) * r + pi * r**2
        V = section * inner[i] + 2 * cap.sum()
        seconds.append(section * inner[i] ** 3 / 12 + 2 * cap @ x**2)
    return Round(rounded_corners(inner / 2, r, facets), V, np.zeros(3), np.diag(seconds))


def ellipsoid(unit: Floats, semi_axes: tuple[float, float, float]) -> Round:
    """From triangles on the unit sphere."""
    a = np.asarray(semi_axes)
    V = 4 / 3 * pi * a.prod()
    return Round(unit * a, V, np.zeros(3), V / 5 * np.diag(a**2))


def _profile(*pieces: tuple) -> Callable[[int], Round]:
    return lambda n: revolved(list(pieces), n, n)


BRACKET = [
    arc((0.8, 0.8), 0.8, 180, 270),
    *ring([(0.8, 0), (3, 0), (3, 1), (1.4, 1)], False),
    arc((1.4, 1.4), 0.4, 270, 180),
    *ring([(1, 1.4), (1, 3), (0, 3), (0, 0.8)], False),
]
"""An L with a fillet within and a rounded heel without."""
SOLIDS: dict[str, Callable[[int], Round]] = {
    "cylinder": _profile(*ring([(0, -1), (1, -1), (1, 1), (0, 1)], False)),
    "tube": _profile(*ring([(0.7, -1), (1, -1), (1, 1), (0.7, 1)])),
    "cone": _profile(*ring([(0, 0), (1, 0), (0, 2)], False)),
    "capsule": _profile(arc((0, -1), 0.5, -90, 0), line((0.5, -1), (0.5, 1)), arc((0, 1), 0.5, 0, 90)),
    "half ball": _profile(line((0, 0), (1, 0)), arc((0, 0), 1, 0, 90)),
    "ball": _profile(arc((0, 0), 1, -90, 90)),
    "rounded disc": _profile(*rounded_disc(2.0, 1.0, 0.25)),
    "pulley": _profile(*PULLEY),
    "torus": _profile(arc((2, 0), 0.5, -180, 180)),
    "ellipsoid": lambda n: ellipsoid(samples.uv_sphere(1.0, max(n // 2, 4), n), (3, 2, 1)),
    "ball of equal triangles": lambda n: ellipsoid(icosphere(max(int(np.log2(n / 5)), 1)), (1, 1, 1)),
    "plate with a hole": lambda n: extruded(
        ring([(-2, -1), (2, -1), (2, 1), (-2, 1)]), [hole((0.7, 0.2), 0.5)], 0.4, n
    ),
    "bracket": lambda n: extruded(BRACKET, [hole((0.5, 2.3), 0.25), hole((2.3, 0.5), 0.25)], 0.6, n),
    "lever": lambda n: extruded(lever(), [hole((0, 0), 0.5), hole((4, 0), 0.2)], 0.5, n),
    "rounded box": lambda n: rounded_box(np.array((1.5, 1.0, 0.5)), 0.25, n),
    "box with small fillets": lambda n: rounded_box(np.array((1.9, 1.4, 0.9)), 0.05, n),
}
"""Round, filleted and drilled parts by the number of facets of a full turn, every corner on the surface."""

Make = Callable[[np.random.Generator, float], Round]


def drawn(kind: str, seed: int, place: str) -> Round:
    """The solid of a kind that this number stands for."""
    rng = np.random.default_rng([seed, sum(map(ord, kind))])
    return KINDS[kind](rng, PLACES[place]).placed(rng)


def _around(rng: np.random.Generator, least: int = 6) -> int:
    """Facets of a turn: as often few as many."""
    return int(np.exp(rng.uniform(np.log(least), np.log(72))))


def _revolved(rng: np.random.Generator, profile: Loop, place: float, facets: int | None = None) -> Round:
    facets = facets or _around(rng, 4)
    return revolved(profile, facets, _around(rng), place)


def _ball(unit: Floats, rng: np.random.Generator, place: float) -> Round:
    p, q, r = unit.transpose(1, 0, 2)
    normal = np.cross(q - p, r - p)
    depth = (np.einsum("ij,ij->i", normal, p) / np.linalg.norm(normal, axis=1)).mean()
    a = np.exp(rng.uniform(0, 1.1, 3)) if rng.random() < 0.7 else np.ones(3)
    return ellipsoid(unit * (1 - place + place / depth), a)


def uv_ball(rng: np.random.Generator, place: float) -> Round:
    profile = _corners([arc((0, 0), 1, -90, 90)], 2 * max(_around(rng) // 2, 3), 0.0)
    return _ball(_turned(profile, _around(rng), 0.0), rng, place)


def ico_ball(rng: np.random.Generator, place: float) -> Round:
    unit = icosphere(int(rng.integers(4)))
    return _ball(unit, rng, place)


def scattered_ball(rng: np.random.Generator, place: float) -> Round:
    points = rng.normal(size=(int(rng.integers(20, 800)), 3))
    return _ball(hull(points / np.linalg.norm(points, axis=1, keepdims=True)), rng, place)


def torus(rng: np.random.Generator, place: float) -> Round:
    major, minor = 1.0, rng.uniform(0.1, 0.9)
    return _revolved(rng, [arc((major, 0), minor, -180, 180)], place, _around(rng))


def cylinder(rng: np.random.Generator, place: float) -> Round:
    h, r = np.exp(rng.uniform(-2, 2)), rng.choice([0.0, rng.uniform(0.2, 0.9)])
    return _revolved(rng, ring([(r, 0), (1, 0), (1, h), (r, h)], bool(r)), place)


def cone(rng: np.random.Generator, place: float) -> Round:
    h, r = np.exp(rng.uniform(-1, 1.5)), rng.choice([0.0, rng.uniform(0.1, 0.9)])
    points = [(0, 0), (1, 0), (r, h), (0, h)]
    return _revolved(rng, ring(points if r else points[:3], False), place)


def capsule(rng: np.random.Generator, place: float) -> Round:
    h, r = np.exp(rng.uniform(-1, 1)), 0.5
    profile = [arc((0, -h), r, -90, 0), line((r, -h), (r, h)), arc((0, h), r, 0, 90)]
    return _revolved(rng, profile, place, _around(rng))


def rounded_block(rng: np.random.Generator, place: float) -> Round:
    inner, r = np.exp(rng.uniform(-1, 1, 3)), np.exp(rng.uniform(-3, 0))
    return rounded_box(inner, r, _around(rng, 4))


def superellipsoid(rng: np.random.Generator, place: float) -> Round:
    a, (e, f) = np.exp(rng.uniform(0, 0.7, 3)), rng.uniform(0.4, 1.5, 2)
    rise = np.linspace(-pi / 2, pi / 2, max(_around(rng) // 2, 3) + 1)
    turn = np.linspace(-pi, pi, 4 * max(_around(rng) // 4, 2), endpoint=False)
    power = lambda x, k: np.sign(x) * np.abs(np.where(np.abs(x) < 1e-12, 0.0, x)) ** k  # noqa: E731
    up, out = power(np.sin(rise), e), power(np.cos(rise), e)
    x, y = (np.outer(out, power(part, f)) for part in (np.cos(turn), np.sin(turn)))
    grid = np.stack([x, y, np.broadcast_to(up[:, None], x.shape)], axis=-1) * a
    beta = lambda p, q: gamma(p) * gamma(q) / gamma(p + q)  # noqa: E731
    size = a.prod() * e * f
    flat = size / 2 * beta(1.5 * f, f / 2) * beta(e / 2, 2 * e + 1)
    tall = 2 * size * beta(f / 2, f / 2 + 1) * beta(1.5 * e, e + 1)
    V = 2 * size * beta(e / 2 + 1, e) * beta(f / 2, f / 2)
    corners = quads(grid + 0.0)
    x, y, z = np.abs(corners.mean(axis=1) / a).T
    depth = ((x ** (2 / f) + y ** (2 / f)) ** (f / e) + z ** (2 / e)) ** (e / 2)
    return Round(corners * (1 - place + place / depth.mean()), V, np.zeros(3), np.diag((flat, flat, tall) * a**2))


def plate(rng: np.random.Generator, place: float) -> Round:
    w, d = rng.uniform(1.5, 4), rng.uniform(1.2, 2)
    holes = [hole((0.3 * s * w, 0), rng.uniform(0.05, 0.2)) for s in (-1, 1)][: rng.integers(3)]
    outline, height = rounded_rectangle(w, d, rng.uniform(0.05, 0.5)), rng.uniform(0.1, 2)
    return extruded(outline, holes, height, _around(rng), place)


def flange(rng: np.random.Generator, place: float) -> Round:
    if rng.random() < 0.5:
        height = rng.uniform(0.2, 2)
        return extruded(lever(), [hole((0, 0), 0.5), hole((4, 0), 0.2)], height, _around(rng), place)
    holes = [hole((0, 0), rng.uniform(0.3, 0.9)), *(hole((1.4 * s, 0), rng.uniform(0.1, 0.35)) for s in (1, -1))]
    height = rng.uniform(0.2, 3)
    return extruded([arc((0, 0), 2, 0, 360)], holes, height, _around(rng), place)


def filleted_shaft(rng: np.random.Generator, place: float) -> Round:
    if rng.random() < 0.3:
        return _revolved(rng, PULLEY, place, _around(rng))
    if rng.random() < 0.5:
        return _revolved(rng, rounded_disc(rng.uniform(1, 3), 1.0, rng.uniform(0.05, 0.45)), place)
    r = rng.uniform(0.1, 0.5)
    profile = [*ring([(0, 0), (1.2, 0), (1.2, 1), (0.6 + r, 1)], False), arc((0.6 + r, 1 + r), r, -90, -180)]
    return _revolved(rng, [*profile, line((0.6, 1 + r), (0.6, 3)), line((0.6, 3), (0, 3))], place)


def tapered_capsule(rng: np.random.Generator, place: float) -> Round:
    """Two balls and the cone that touches both."""
    r, h = rng.uniform(0.2, 0.8), rng.uniform(1, 4)
    lean = np.arcsin((1 - r) / h)
    turn = np.degrees(lean)
    low, high = arc((0, 0), 1.0, -90, turn), arc((0, h), r, turn, 90)
    tangent = np.array((np.cos(lean), np.sin(lean)))
    return _revolved(rng, [low, line(tangent, (0, h) + r * tangent), high], place, _around(rng))


def uneven_ball(rng: np.random.Generator, place: float) -> Round:
    """Of rings and sectors at unequal steps."""
    steps = lambda n: np.cumsum(rng.uniform(0.5, 1.5, n))  # noqa: E731
    rise, turn = steps(max(_around(rng) // 2, 4)), steps(_around(rng))
    rise = pi * np.append(0.0, rise / rise[-1])
    turn = 2 * pi * turn / turn[-1]
    out = np.where((rise == 0) | (rise == pi), 0.0, np.sin(rise))
    x, y = (np.outer(out, part) for part in (np.cos(turn), np.sin(turn)))
    return _ball(quads(np.stack([x, y, np.broadcast_to(-np.cos(rise)[:, None], x.shape)], axis=-1) + 0.0), rng, place)


def elliptic_prism(rng: np.random.Generator, place: float) -> Round:
    """Perhaps with a hole, nearer to one end."""
    facets, h = _around(rng), rng.uniform(0.2, 3)
    t, out = 2 * pi * np.arange(facets) / facets, _out(2 * pi / facets, place)
    sizes, shift = np.array((1.0, rng.uniform(0.4, 1))), np.array((rng.uniform(0, 0.3), 0.0))
    ellipses = [(1, sizes, 0 * shift), (-1, sizes * rng.uniform(0.2, 0.6), shift)][: rng.integers(1, 3)]
    area, first, S, rings = 0.0, np.zeros(3), np.zeros((3, 3)), []
    for way, half, middle in ellipses:
        A, c = way * pi * half.prod(), np.append(middle, 0.0)
        area, first = area + A, first + A * c
        S += A * (np.diag((*half**2 / 4, h**2 / 12)) + np.outer(c, c))
        rings.append((out * half * np.column_stack([np.cos(t), np.sin(t)]) + middle)[::way])
    return Round(prism(rings, h), area * h, first / area, h * (S - np.outer(first, first) / area))


def spool(rng: np.random.Generator, place: float) -> Round:
    """A waist of one arc between two flat ends, of three facets at least: fewer would tell nothing of it."""
    half, wide = rng.uniform(20, 70), rng.uniform(0.2, 1)
    reach = 1 / np.sin(np.radians(half))
    top = reach * np.cos(np.radians(half))
    waist = arc((wide + reach, 0), reach, 180 + half, 180 - half)
    rim = wide + reach - top
    profile = [line((0, -1), (rim, -1)), waist, line((rim, 1), (0, 1))]
    return _revolved(rng, profile, place, max(_around(rng), ceil(2.01 * 180 / half)))


TUNED: dict[str, Make] = {
    "UV spheres and ellipsoids": uv_ball,
    "cylinders and tubes": cylinder,
    "cones and truncated cones": cone,
    "capsules": capsule,
    "rounded boxes": rounded_block,
    "plates with rounded corners and holes": plate,
}
TRIED: dict[str, Make] = {
    "tori": torus,
    "icospheres and ellipsoids": ico_ball,
    "ellipsoids with scattered corners": scattered_ball,
    "superellipsoids": superellipsoid,
    "shafts with fillets and grooves": filleted_shaft,
    "levers and flanges": flange,
    "spools": spool,
}
HELD_OUT: dict[str, Make] = {
    "tapered capsules": tapered_capsule,
    "ellipsoids with uneven steps": uneven_ball,
    "elliptic prisms and tubes": elliptic_prism,
}
KINDS = TUNED | TRIED | HELD_OUT
