"""What facets leave out of the smooth body that they may stand for: told by the angles at which they meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import radians
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.programs.vectors import Array, arctan2, length, product
from robodyn.solids.inertia.laws import inertia_matrix
from robodyn.solids.mesh.indexed import Mask, components, hashed, paired
from robodyn.solids.mesh.integrals import Integrals
from robodyn.support.floats import Floats, median
from robodyn.support.linear import eigen

Integers = NDArray[np.int64]

_SHARPEST = radians(65)
"""Facets that meet at a larger angle are meant so, unless both belong to curved faces."""
_WIDEST = radians(120)
_BENT = 1e-3
"""Below this many radians an angle may be a rounding error."""
_FLAT = 1e-5
_EDGES = 1 << 14
_COLUMNS = ("start", "end", "angle", "length", "heights", "feet", "outward", "triangles")
_UNLIKE = 3
_UNPAIRED = 0.6
_SAME = 0.1
OUTSIDE = 0.5
"""Of what facets lack where their corners are on the smooth surface, that they take in where they touch it."""
SHIFT = 0.6
"""Of what the centre would move if all doubt were on one side, how far it may."""


@dataclass(frozen=True, eq=False)
class BentEdges:
    """Edges of two triangles, from start to end (3, k), that meet at an angle below 120 degrees which is not zero.

    angle: (k,) between the normals [rad], positive where the surface is convex; heights: (2, k) of the triangles over
    the edge; feet: (2, k) where the corners opposite to it stand over it, from 0 at its start to 1 at its end; outward:
    (2, 3, k) unit vectors across the edge in the plane of either triangle, out of it; triangles: (2, k) their numbers;
    flat: (m,) whether a triangle lies in one plane with another one; facet: (m,) number of the connected triangles in
    one plane that each belongs to; areas: (m,) of these.
    """

    start: Floats
    end: Floats
    angle: Floats
    length: Floats
    heights: Floats
    feet: Floats
    outward: Floats
    triangles: Integers
    flat: Mask
    facet: Integers
    areas: Floats

    def among(self, chosen: Mask) -> BentEdges:
        if chosen.all():
            return self
        return replace(self, **{name: getattr(self, name)[..., chosen] for name in _COLUMNS})


def bent_edges(corners: Array) -> BentEdges:
    """The bent edges of triangles (m, 3, 3), wound outwards, that have the same bits in both triangles of an edge."""
    X = np.ascontiguousarray(corners.transpose(1, 2, 0))
    points = np.ascontiguousarray(X.transpose(0, 2, 1)).reshape(-1, 3)
    u, v = X[1] - X[0], X[2] - X[0]
    normals = np.stack([u[i - 2] * v[i - 1] - u[i - 1] * v[i - 2] for i in range(3)], axis=1)
    hashes = hashed(X)
    one, other = paired(np.concatenate([hashes[i - 3] + hashes[i - 2] for i in range(3)]))
    coplanar: list[Integers] = []
    blocks = (slice(k, k + _EDGES) for k in range(0, max(len(one), 1), _EDGES))
    parts = [_bent(points, normals, one[block], other[block], coplanar) for block in blocks]
    columns: dict[str, Any] = {name: np.concatenate([part.pop(name) for part in parts], axis=-1) for name in _COLUMNS}
    a, b = np.concatenate(coplanar, axis=1)
    flat = np.zeros(len(normals), dtype=np.bool_)
    flat[a] = flat[b] = True
    facet = components(len(normals), a, b)
    of_facets: Floats = np.bincount(facet, np.sqrt((normals * normals).sum(axis=1)) / 2).astype(np.float64)
    return BentEdges(**columns, flat=flat, facet=facet, areas=of_facets[facet])


def _bent(
    points: Floats, normals: Floats, one: Integers, other: Integers, coplanar: list[Integers]
) -> dict[str, Array]:
    """Return the columns of `BentEdges` of some edges; coplanar gets the pairs (2, n) of triangles in one plane. Points
    (3 m, 3) by corner, then triangle; normals (m, 3) as long as twice the areas."""
    count = len(normals)
    triangles = np.stack([one, other]) % count
    first, second = np.ascontiguousarray(normals.take(triangles, axis=0).transpose(0, 2, 1))
    cosine = first[0] * second[0] + first[1] * second[1] + first[2] * second[2]
    cross = np.stack([first[i - 2] * second[i - 1] - first[i - 1] * second[i - 2] for i in range(3)])
    sine = np.sqrt(cross[0] ** 2 + cross[1] ** 2 + cross[2] ** 2)
    coplanar.append(triangles[:, (sine <= _BENT * cosine) & (cosine > 0)])
    angle = arctan2(sine, cosine)
    (kept,) = np.nonzero((angle > _FLAT) & (angle < _WIDEST))
    one, other = one[kept], other[kept]
    start, end = points.take(one, axis=0).T, points.take((one + count) % len(points), axis=0).T
    along = end - start
    length = np.sqrt(along[0] ** 2 + along[1] ** 2 + along[2] ** 2)
    angle = np.copysign(angle[kept], (cross[:, kept] * along).sum(axis=0))
    sides = np.stack([first[:, kept], second[:, kept]])
    sizes = np.sqrt((sides * sides).sum(axis=1))
    outward = np.stack([along[i - 2] * sides[:, i - 1] - along[i - 1] * sides[:, i - 2] for i in range(3)], axis=1)
    outward /= np.array([[1.0], [-1.0]])[:, None] * (sizes * length)[:, None]
    opposite = points.take(np.stack([one, other]) + 2 * count, axis=0, mode="wrap").transpose(2, 0, 1)
    feet = ((opposite - start[:, None]) * along[:, None]).sum(axis=0) / length**2
    found = (start, end, angle, length, sizes / length, feet, outward, triangles[:, kept])
    return dict(zip(_COLUMNS, found, strict=True))


def _unpaired(edges: BentEdges, among: Mask) -> Floats:
    """(2, k) what some edges of the facet on each side leave unpaired across this one, over its length. Lengths times
    outward vectors add up to zero around a facet: what some edges leave is what the others have. Above _UNPAIRED others
    are opposite to this one, below -_UNPAIRED some of these, none of which is it."""
    facet = edges.facet[edges.triangles].ravel()
    weights = (edges.outward * np.where(among, edges.length, 0.0)).transpose(1, 0, 2).reshape(3, -1)
    left = np.stack([np.bincount(facet, one, len(edges.areas)) for one in weights])[:, facet].reshape(3, 2, -1)
    found: Floats = (left * edges.outward.transpose(1, 0, 2)).sum(axis=0) / edges.length
    return found


def _companions(edges: BentEdges, among: Mask, either: bool = False) -> Floats:
    """(2, k) the largest angle at others of these edges of the facet on each side that bend the same way, else 0."""
    size = np.tile(np.where(among, np.abs(edges.angle), 0.0), 2)
    if not len(size):
        return np.zeros((2, 0))
    facet = 2 * edges.facet[edges.triangles].ravel() + (not either) * (np.tile(edges.angle, 2) < 0)
    largest, second = np.zeros((2, 2 * len(edges.areas)))
    np.maximum.at(largest, facet, size)
    top = size == largest[facet]
    np.maximum.at(second, facet, np.where(top, 0.0, size))
    only = top & (np.bincount(facet, top)[facet] == 1)
    found = np.where(only, second[facet], largest[facet])
    return found.reshape(2, -1)


def _like(edges: BentEdges) -> Mask:
    """(k,) whether the facets on both sides are of the same kind, and not the plane that a fillet touches."""
    areas = edges.areas[edges.triangles]
    like: Mask = areas.max(axis=0) <= _UNLIKE * areas.min(axis=0)
    return like


FINE = radians(40)
"""Facets that meet at a larger angle are too coarse to say how symmetric a body may be that they stand for."""
_TIMES_MEDIAN = 3
_SQUARE = radians(88)
_SIMILAR = 1 / 3
_INNER = 1.4
_BESIDE = 0.02
_SHARE = 0.25
_ALONE = 0.6
_SHARP = 0.9
_ENDING = 1.5
_FAR = 0.75
_STEEP = 0.35
_WIDE = 0.35
_CLEARLY = 0.05


@dataclass(frozen=True, eq=False)
class LineMasses:
    """What lies between facets and surface, spread evenly along each edge, from start (3, k) to end (3, k).

    missing: (k,) volume, negative where facets take in too much; doubt: (k,) how far it may be from that; fine: (k,)
    whether the angle is below 40 degrees, and below three times the median one.
    """

    start: Floats
    end: Floats
    missing: Floats
    doubt: Floats
    fine: Mask


def line_masses(corners: Array) -> LineMasses:
    """The volume that facets leave out, as far as angles and heights tell, where corners are on the smooth surface.

    An edge of length l between triangles of heights h1, h2 that meet at an angle th lacks l h_i^2 t_i / 24 on either
    side, t_i = 2 th h_i / (h1 + h2): that is the volume between a cylinder, or any surface of the second order, and a
    regular grid of facets, but for higher orders of th. A facet is all triangles in one plane. Exceptions are these.

    - Where the facet on one side is more than three times the other, it lies in a plane that touches a fillet, unless
      it is a triangle whose edges are all bent and one has facets more alike: t = 0 on its side, 2 th on the other.
    - A triangle with two bent edges, bent by more than 0.35 of the angle between them, and a sharp one is at the apex
      of a cone: that lacks a third. Between equal trapezoids of widths w1, w2 an edge lacks
      l th (w1^2 + w1 w2 + w2^2) / 36.
    - A facet that has no other edge which is bent the same way by a third of this one at least, or at a plane by 1.4
      times, may be curved or not: half of what would be missing is, and 0.6 of it is doubt.
    - Where neither facet is bent anywhere else, as at the ridge of a roof, nothing is missing.
    - Edges of 65 to 120 degrees are meant as they are, unless the facets are of a kind and both have other bent edges
      below 65, and above 88 degrees these opposite to them: then that is in doubt.
    - Where a curved facet ends at a sharp edge opposite to this one, there is no edge to stand for the far half of it:
      that lacks as much again, at three quarters of the way across.

    The doubt is a quarter of what is missing, and l th (h1 - h2)^2 / 9 where triangles are uneven; and one and a half
    times all of it at such an end, and at the apex of a coarse cone.

    Args:
        corners: (m, 3, 3), wound outwards; an edge has the same bits in both its triangles.
    """
    edges = bent_edges(corners)
    angle = np.abs(edges.angle)
    sharp = angle > _SHARPEST
    if sharp.any():
        bent = (_companions(edges, ~sharp) > _BENT).all(axis=0) & (angle < _SQUARE)
        opposed = (_unpaired(edges, ~sharp & (angle > _BENT)) < -_UNPAIRED).all(axis=0)
        sharp &= ~(_like(edges) & (bent | opposed))
    ratio = _companions(edges, angle <= _SHARPEST) / angle
    meant = sharp | ((ratio <= _BESIDE).all(axis=0) & (angle <= _SHARPEST))
    edges = edges.among(~meant)
    size = np.abs(edges.angle)
    counted = size[size > _BENT] if (size > _BENT).any() else size
    typical = median(counted) if len(size) else 0.0
    fine = size < min(FINE, _TIMES_MEDIAN * typical)
    parts = _of_smooth(edges, _CLEARLY * typical)
    start, end, missing, doubt, edge = (np.concatenate(column, axis=-1) for column in zip(*parts, strict=True))
    return LineMasses(start, end, missing, doubt, fine[edge])


def _of_smooth(edges: BentEdges, least: float) -> list[tuple[Floats, Floats, Floats, Floats, Integers]]:
    """Starts, ends, missing volumes, doubts and numbers of edges: at these, and at the far ends of facets on each side.

    At the apex of a cone volume is missing as the square of the distance s from it: at 3/4 of the length on the
    average. It is spread along the half away from it, where that is so, too; the mean of s^2 is 0.6, and 0.583 there.
    Below the `least` angle an edge may be one of a plane, and says nothing about its triangles.
    """
    clear = np.abs(edges.angle) > least
    count = np.bincount(edges.triangles[:, clear].ravel(), minlength=len(edges.flat))
    alike = np.zeros_like(edges.flat)
    alike[edges.triangles[:, _like(edges) & clear]] = True
    areas, heights = edges.areas[edges.triangles], edges.heights
    plane = (areas > _UNLIKE * areas[::-1]) & ~(alike & (count == 3))[edges.triangles]
    volume = edges.length * edges.angle / 12
    even = volume * heights**3 / heights.sum(axis=0)
    lacking = np.where(plane, 0.0, np.where(plane[::-1], volume * heights**2, even))
    size, angle = np.abs(lacking), np.abs(edges.angle)
    sharp = angle > _SHARPEST
    alone = _companions(edges, ~sharp) / angle < np.where(plane[::-1], _INNER, _SIMILAR)
    curved = _companions(edges, ~sharp, either=True) > _BESIDE * angle
    apex = ((count == 2) & ~edges.flat)[edges.triangles]
    steep = apex & (angle * edges.length > _STEEP * heights)
    wide = steep & (heights > _WIDE * edges.length)
    # between equal trapezoids of widths w1, w2 lacks l th (w1^2 + w1 w2 + w2^2) / 36, but the rule for heights says
    # l th (w1^2 - w1 w2 + w2^2) / 12
    differ = edges.length * edges.angle * (heights[0] - heights[1]) ** 2
    tapers = edges.flat[edges.triangles].all(axis=0) & (np.abs(areas[0] - areas[1]) <= _SAME * areas.sum(axis=0))
    less, uneven = np.where(tapers, differ / 18, 0.0), np.where(_like(edges), np.abs(differ) / 9, 0.0)
    uneven = np.where(tapers, uneven / 4, uneven)
    missing = np.where(steep, lacking / 3, np.where(alone, lacking / 2, lacking))
    share = np.where(sharp, _SHARP, np.where(alone, _ALONE, _SHARE)) + np.where(wide, _ENDING, 0.0)
    here = np.where(sharp, 0.0, missing.sum(axis=0) - less), (share * size).sum(axis=0) + uneven
    middle, at_start, half = (edges.start + edges.end) / 2, edges.feet.mean(axis=0) > 0.5, steep.all(axis=0)
    start, end = np.where(half & at_start, middle, edges.start), np.where(half & ~at_start, middle, edges.end)
    found = [(start, end, *here, np.arange(len(angle)))]
    ending = (_unpaired(edges, np.abs(edges.angle) > _BENT) > _UNPAIRED) & ~steep & curved
    for side in (0, 1):
        (chosen,) = np.nonzero(ending[side])
        across = edges.outward[side][:, chosen] * (_FAR * heights[side][chosen])
        there = np.where(sharp, 0.0, missing[side])[chosen], _ENDING * size[side][chosen]
        found.append((edges.start[:, chosen] - across, edges.end[:, chosen] - across, *there, chosen))
    return found


@dataclass(frozen=True)
class Bars:
    """How far numbers may be from those of the smooth body, relative to these; infinite where nothing can be said.

    inertia: the largest error among all axes through the centre, relative to the largest principal moment; centre: the
    distance of the centres, relative to the largest radius of gyration.
    """

    volume: float
    inertia: float
    centre: float


EXACT = Bars(0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Tessellation:
    """Integrals over the smooth body that a mesh may stand for, if its corners are on the smooth surface.

    mesh: bars of the mesh's own integrals; rest: of the corrected ones, wherever the corners are; on_surface: if there.
    """

    corrected: Integrals
    mesh: Bars
    rest: Bars
    on_surface: Bars


def tessellation(masses: LineMasses, integrals: Integrals, centre: Array, *, fixed_mass: bool = False) -> Tessellation:
    """Line masses added to the volume, first and second moments of a mesh.

    Where corners are on the smooth surface, the bar of the corrected numbers is the doubt of all edges added up. Where
    facets touch it, half of what they would lack is too much: bars take in both places, for convex and for concave
    faces. Edges of more than 65 degrees are meant as they are: no bar speaks of them.

    Args:
        masses: of the mesh, wound outwards, about its centre.
        integrals: of the same mesh, of either winding. centre: (3,) of its mass, in units of the file.
        fixed_mass: the bars of the inertia are those at a given mass, not at a given density.
    """
    if not len(masses.missing):
        return Tessellation(integrals, EXACT, EXACT, EXACT)
    V, sign = abs(integrals.volume), np.sign(integrals.volume)
    arm = integrals.first / integrals.volume
    S_c = sign * integrals.S - V * np.outer(arm, arm)
    parts = [_line_moments(masses, np.maximum(side * masses.missing, 0.0) * side) for side in (1, -1)]

    def smooth(lacks: float, takes: float) -> _Smooth:
        """The smooth body with so many times what facets lack and what they take in too much."""
        volume, first, second = (lacks * one + takes * other for one, other in zip(*parts, strict=True))
        whole = max(V + volume, V / 4)
        S = S_c + second - np.outer(first, first) / whole
        return _Smooth(whole, S * (V / whole) if fixed_mass else S, first / whole)

    given, on = smooth(0, 0), smooth(1, 1)
    places = [smooth(one, other) for one in (1, -OUTSIDE) for other in (1, -OUTSIDE)]
    doubt, lean, spread = _line_moments(masses, masses.doubt)
    middle = (masses.start + masses.end) / 2
    moment = float((masses.doubt * np.sqrt((middle * middle).sum(axis=0))).sum())
    shift = (length(lean) + SHIFT * moment) / min(one.volume for one in (given, *places))
    doubts = np.array([doubt, _largest(spread) + (_largest(S_c) * doubt / V if fixed_mass else 0.0), shift])
    volume, first, second = (one + other for one, other in zip(*parts, strict=True))
    shift_back = centre - integrals.reference
    across = np.outer(first, shift_back)
    corrected = replace(
        integrals,
        volume=integrals.volume + sign * volume,
        first=integrals.first + sign * (first + volume * shift_back),
        S=integrals.S + sign * (second + across + across.T + volume * np.outer(shift_back, shift_back)),
        unrounded=None,
    )
    return Tessellation(
        corrected, mesh=_bars(given, places, doubts), rest=_bars(on, places, doubts), on_surface=_bars(on, [on], doubts)
    )


class _Smooth(NamedTuple):
    volume: float
    S: Floats
    centre: Floats


def _bars(found: _Smooth, places: Sequence[_Smooth], doubts: Floats) -> Bars:
    """Return the largest errors over the least sizes that the smooth body may have, infinite above the whole."""
    own, shares = np.array([found.volume, _largest(found.S)]), []
    for true in places:
        size, apart = _largest(true.S), length(found.centre - true.centre)
        errors = np.array([abs(found.volume - true.volume), _largest(found.S - true.S), apart]) + doubts
        sizes = np.array([true.volume, size, (size / true.volume) ** 0.5])
        sizes[:2] = np.minimum(own, sizes[:2] - doubts[:2])
        shares.append(np.where(errors < sizes, errors / np.where(sizes > 0, sizes, 1.0), np.inf))
    volume, inertia, centre = np.max(shares, axis=0).tolist()
    return Bars(volume, inertia, centre)


def _line_moments(masses: LineMasses, weights: Floats) -> tuple[float, Floats, Floats]:
    """Integrals of 1, x, x x^T for weights m along edges p to q, s = p + q: m, m s / 2, m (pp^T + qq^T + ss^T) / 6."""
    p, q = masses.start, masses.end
    s = p + q
    second = sum(product(x * weights, x.T) for x in (p, q, s))
    return float(weights.sum()), product(s, weights) / 2, np.asarray(second) / 6


def _largest(S: Floats) -> float:
    return float(np.abs(eigen(inertia_matrix(S))[0]).max())
