"""Round solids of random kind, proportions, coarseness and pose, with their exact moments.

Corners lie on the surface, outside of it so that facets touch it, or between; facets of arcs take 60 degrees at most.
Kinds are split: the numbers of the estimate are tuned on `TUNED`, its rules come of `TRIED` as well, and nothing comes
of `HELD_OUT`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, cos, gamma, pi

import numpy as np

from helpers import smooth_solids
from helpers.mesh_oracle import rotation
from helpers.plane_curves import Loop, arc, circle, hole, lever, line, pulley_top, ring, rounded_disc
from helpers.plane_curves import rounded_rectangle as rounded
from helpers.tessellations import hull, prism, quads, quartered, rounded_corners

Floats = np.ndarray
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


Make = Callable[[np.random.Generator, float], Round]


def drawn(kind: str, seed: int, place: str) -> Round:
    """The solid of a kind that this number stands for."""
    rng = np.random.default_rng([seed, sum(map(ord, kind))])
    return KINDS[kind](rng, PLACES[place]).placed(rng)


def _around(rng: np.random.Generator, least: int = 6) -> int:
    """Facets of a turn: as often few as many."""
    return int(np.exp(rng.uniform(np.log(least), np.log(72))))


def _out(angle: float, place: float) -> float:
    """Factor on the radius of corners that are so many radians apart."""
    return 1 - place + place / cos(angle / 2)


def _turned(points: Floats, sectors: int, place: float) -> Floats:
    """About z; points (n, 2) of a profile upwards along the outside."""
    angle = 2 * pi * np.arange(sectors) / sectors
    reach = np.where(np.abs(points[:, 0]) < 1e-12, 0.0, points[:, 0]) * _out(2 * pi / sectors, place)
    x, y = (np.outer(reach, part) for part in (np.cos(angle), np.sin(angle)))
    return quads(np.stack([x, y, np.broadcast_to(points[:, 1:], x.shape)], axis=-1) + 0.0)


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


def _of(solid: smooth_solids.Solid, corners: Floats) -> Round:
    return Round(corners, solid.volume, solid.com, solid.S)


def _revolved(rng: np.random.Generator, profile: Loop, place: float, facets: int | None = None) -> Round:
    points = _corners(profile, facets or _around(rng, 4), place)
    return _of(smooth_solids.revolved("", profile), _turned(points, _around(rng), place))


def _extruded(rng: np.random.Generator, outline: Loop, holes: list[Loop], height: float, place: float) -> Round:
    facets = _around(rng)
    rings = [_corners(loop, facets, place)[:-1] for loop in (outline, *holes)]
    return _of(smooth_solids.extruded("", outline, holes, height), prism(rings, height))


def _ball(unit: Floats, rng: np.random.Generator, place: float) -> Round:
    """An ellipsoid, from triangles on the unit sphere."""
    p, q, r = unit.transpose(1, 0, 2)
    normal = np.cross(q - p, r - p)
    depth = (np.einsum("ij,ij->i", normal, p) / np.linalg.norm(normal, axis=1)).mean()
    a = np.exp(rng.uniform(0, 1.1, 3)) if rng.random() < 0.7 else np.ones(3)
    V = 4 / 3 * pi * a.prod()
    return Round(unit * (1 - place + place / depth) * a, V, np.zeros(3), V / 5 * np.diag(a**2))


def uv_ball(rng: np.random.Generator, place: float) -> Round:
    profile = _corners([arc((0, 0), 1, -90, 90)], 2 * max(_around(rng) // 2, 3), 0.0)
    return _ball(_turned(profile, _around(rng), 0.0), rng, place)


def ico_ball(rng: np.random.Generator, place: float) -> Round:
    golden = (1 + 5**0.5) / 2
    points = np.array([(s, t * golden, 0) for s in (-1, 1) for t in (-1, 1)], float)
    unit = hull(np.concatenate([np.roll(points, k, axis=1) for k in range(3)]) / np.linalg.norm(points[0]))
    for _ in range(int(rng.integers(4))):
        unit = quartered(unit)
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


def rounded_box(rng: np.random.Generator, place: float) -> Round:
    inner, r = np.exp(rng.uniform(-1, 1, 3)), np.exp(rng.uniform(-3, 0))
    solid = smooth_solids.rounded_box("", tuple(inner + 2 * r), r)
    return _of(solid, rounded_corners(inner / 2, r, _around(rng, 4)))


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
    return _extruded(rng, rounded(w, d, rng.uniform(0.05, 0.5)), holes, rng.uniform(0.1, 2), place)


def flange(rng: np.random.Generator, place: float) -> Round:
    if rng.random() < 0.5:
        return _extruded(rng, lever(), [hole((0, 0), 0.5), hole((4, 0), 0.2)], rng.uniform(0.2, 2), place)
    holes = [hole((0, 0), rng.uniform(0.3, 0.9)), *(hole((1.4 * s, 0), rng.uniform(0.1, 0.35)) for s in (1, -1))]
    return _extruded(rng, circle((0, 0), 2), holes, rng.uniform(0.2, 3), place)


def filleted_shaft(rng: np.random.Generator, place: float) -> Round:
    if rng.random() < 0.3:
        profile = [*ring([(0.5, -1), (2, -1), (2, -0.8)], False), arc((2, 0), 0.8, -90, -270), *pulley_top()]
        return _revolved(rng, profile, place, _around(rng))
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
    "rounded boxes": rounded_box,
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
