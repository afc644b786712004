"""What facets leave out of the smooth body that they may stand for: masses along edges, corrected integrals, bars."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import radians

import numpy as np

from robodyn.programs.linear import eigen
from robodyn.programs.vectors import Array, length, product
from robodyn.solids.inertia.laws import inertia_matrix
from robodyn.solids.mesh.facets import (
    BENT,
    SHARPEST,
    BentEdges,
    Integers,
    bent_edges,
    companions,
    endings,
    like,
    opposed,
    planes,
    sides,
    taper,
)
from robodyn.solids.mesh.indexed import Mask
from robodyn.solids.mesh.integrals import Integrals
from robodyn.support.floats import Floats, median

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

    Attributes:
        missing: (k,) volume, negative where facets take in too much. doubt: (k,) how far it may be from that.
        fine: (k,) whether the angle is below 40 degrees, and below three times the median one.
    """

    start: Floats
    end: Floats
    missing: Floats
    doubt: Floats
    fine: Mask

    @property
    def size(self) -> float:
        """The volume between fine facets and the surface, whatever its sign."""
        return float(np.abs(self.missing[self.fine]).sum())


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
    edges = _smooth(bent_edges(corners))
    size = np.abs(edges.angle)
    counted = size[size > BENT] if (size > BENT).any() else size
    typical = median(counted) if len(size) else 0.0
    fine = size < min(FINE, _TIMES_MEDIAN * typical)
    parts = _of_smooth(edges, _CLEARLY * typical)
    start, end, missing, doubt, edge = (np.concatenate(column, axis=-1) for column in zip(*parts, strict=True))
    return LineMasses(start, end, missing, doubt, fine[edge])


def _smooth(edges: BentEdges) -> BentEdges:
    """Without those that are meant as they are."""
    angle = np.abs(edges.angle)
    sharp = angle > SHARPEST
    if sharp.any():
        bent = (companions(edges, ~sharp) > BENT).all(axis=0) & (angle < _SQUARE)
        sharp &= ~(like(edges) & (bent | opposed(edges, ~sharp & (angle > BENT))))
    ratio = companions(edges, angle <= SHARPEST) / angle
    meant = sharp | ((ratio <= _BESIDE).all(axis=0) & (angle <= SHARPEST))
    return edges.among(~meant)


def _spread(edges: BentEdges, steep: Mask) -> tuple[Floats, Floats]:
    """Starts and ends (3, k) of where volume is missing: at the apex of a cone the half away from it.

    There it is missing as the square of the distance s from the apex: at 3/4 of the length on the average, as in that
    half; the mean of s^2 is 0.6, and 0.583 there.
    """
    middle = (edges.start + edges.end) / 2
    at_start = edges.feet.mean(axis=0) > 0.5
    return np.where(steep & at_start, middle, edges.start), np.where(steep & ~at_start, middle, edges.end)


def _of_smooth(edges: BentEdges, least: float) -> list[tuple[Floats, Floats, Floats, Floats, Integers]]:
    """Starts, ends, missing volumes, doubts and numbers of edges: at these, and at the far ends of facets on each side.

    Args:
        least: angle below which an edge may be one of a plane, and says nothing about its triangles.
    """
    clear = np.abs(edges.angle) > least
    count = np.bincount(edges.triangles[:, clear].ravel(), minlength=len(edges.flat))
    alike = np.zeros_like(edges.flat)
    alike[edges.triangles[:, like(edges) & clear]] = True
    plane = planes(edges, alike & (count == 3))
    lacking = sides(edges, plane)
    size, angle = np.abs(lacking), np.abs(edges.angle)
    sharp = angle > SHARPEST
    alone = companions(edges, ~sharp) / angle < np.where(plane[::-1], _INNER, _SIMILAR)
    curved = companions(edges, ~sharp, either=True) > _BESIDE * angle
    apex = ((count == 2) & ~edges.flat)[edges.triangles]
    steep = apex & (angle * edges.length > _STEEP * edges.heights)
    wide = steep & (edges.heights > _WIDE * edges.length)
    less, uneven = taper(edges)
    missing = np.where(steep, lacking / 3, np.where(alone, lacking / 2, lacking))
    share = np.where(sharp, _SHARP, np.where(alone, _ALONE, _SHARE)) + np.where(wide, _ENDING, 0.0)
    here = np.where(sharp, 0.0, missing.sum(axis=0) - less), (share * size).sum(axis=0) + uneven
    found = [(*_spread(edges, steep.all(axis=0)), *here, np.arange(len(angle)))]
    ending = endings(edges) & ~steep & curved
    for side in (0, 1):
        (chosen,) = np.nonzero(ending[side])
        across = edges.outward[side][:, chosen] * (_FAR * edges.heights[side][chosen])
        there = np.where(sharp, 0.0, missing[side])[chosen], _ENDING * size[side][chosen]
        found.append((edges.start[:, chosen] - across, edges.end[:, chosen] - across, *there, chosen))
    return found


OUTSIDE = 0.5
"""Of what facets lack where their corners are on the smooth surface, that they take in where they touch it."""

SHIFT = 0.6
"""Of what the centre would move if all doubt were on one side, how far it may."""


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
    """Integrals over the smooth body that a mesh may stand for.

    Attributes:
        corrected: those of the mesh with what its facets leave out if its corners are on the smooth surface.
        mesh: bars of the mesh's own integrals, wherever its corners are.
        rest: of the corrected ones, wherever the corners are. on_surface: if they are on the surface.
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
    V = abs(integrals.volume)
    arm = integrals.first / integrals.volume
    body = _Body(V, np.sign(integrals.volume) * integrals.S - V * np.outer(arm, arm), fixed_mass)
    parts = [_line_moments(masses, np.maximum(side * masses.missing, 0.0) * side) for side in (1, -1)]
    given, on = body.smooth(parts, 0, 0), body.smooth(parts, 1, 1)
    places = [body.smooth(parts, one, other) for one in (1, -OUTSIDE) for other in (1, -OUTSIDE)]
    doubt, lean, spread = _line_moments(masses, masses.doubt)
    middle = (masses.start + masses.end) / 2
    moment = float((masses.doubt * np.sqrt((middle * middle).sum(axis=0))).sum())
    shift = (length(lean) + SHIFT * moment) / min(one.volume for one in (given, *places))
    doubts = np.array([doubt, _largest(spread) + (_largest(body.S) * doubt / V if fixed_mass else 0.0), shift])
    volume, first, second = (one + other for one, other in zip(*parts, strict=True))
    sign, shift_back = np.sign(integrals.volume), centre - integrals.reference
    across = np.outer(first, shift_back)
    corrected = replace(
        integrals,
        volume=integrals.volume + sign * volume,
        first=integrals.first + sign * (first + volume * shift_back),
        S=integrals.S + sign * (second + across + across.T + volume * np.outer(shift_back, shift_back)),
        unrounded=None,
    )
    return Tessellation(
        corrected,
        mesh=_bars(given, places, doubts),
        rest=_bars(on, places, doubts),
        on_surface=_bars(on, [on], doubts),
    )


@dataclass(frozen=True, eq=False)
class _Smooth:
    volume: float
    S: Floats
    centre: Floats

    def errors(self, true: _Smooth) -> Floats:
        """(3,) of volume, largest moment of inertia and centre, where this body is the true one."""
        distance = length(self.centre - true.centre)
        return np.array([abs(self.volume - true.volume), _largest(self.S - true.S), distance])

    @property
    def sizes(self) -> Floats:
        """(3,) of what errors are relative to."""
        size = _largest(self.S)
        return np.array([self.volume, size, (size / self.volume) ** 0.5])


@dataclass(frozen=True, eq=False)
class _Body:
    """Volume and second moments of a mesh about its centre, and whether its mass is given."""

    V: float
    S: Floats
    fixed_mass: bool

    def smooth(self, parts: Sequence[tuple[float, Floats, Floats]], lacks: float, takes: float) -> _Smooth:
        """The smooth body with so many times what facets lack and what they take in too much."""
        volume, first, second = (lacks * one + takes * other for one, other in zip(*parts, strict=True))
        whole = max(self.V + volume, self.V / 4)
        S = self.S + second - np.outer(first, first) / whole
        return _Smooth(whole, S * (self.V / whole) if self.fixed_mass else S, first / whole)


def _bars(found: _Smooth, places: Sequence[_Smooth], doubts: Floats) -> Bars:
    """Return the largest errors over the least sizes that the smooth body may have, infinite above the whole."""
    shares = []
    for true in places:
        errors, sizes = found.errors(true) + doubts, true.sizes
        sizes[:2] = np.minimum(found.sizes, sizes - doubts)[:2]
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
