"""What a body of facets leaves out of the smooth one it may stand for: corrected integrals, and error bars."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robodyn.programs.linear import eigen
from robodyn.programs.vectors import Array, length, product
from robodyn.solids.inertia.laws import inertia_matrix
from robodyn.solids.mesh.integrate.integrals import Integrals
from robodyn.solids.mesh.tessellation.lines import LineMasses
from robodyn.support.floats import Floats

OUTSIDE = 0.5
"""Of what facets lack where their corners are on the smooth surface, that they take in where they touch it."""

SHIFT = 0.6
"""Of what the centre would move if all doubt were on one side, how far it may."""


@dataclass(frozen=True)
class Bars:
    """How far numbers may be from those of the smooth body, relative to those of the smooth body.

    Attributes:
        volume: infinite where nothing can be said.
        inertia: of the largest error among all axes through the centre, relative to the largest principal moment.
        centre: of the distance of the centres, relative to the largest radius of gyration.
    """

    volume: float
    inertia: float
    centre: float


EXACT = Bars(0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Tessellation:
    """Integrals over the smooth body that a mesh may stand for.

    Attributes:
        corrected: those of the mesh with what its facets leave out if its corners are on the smooth surface; the same
            object where none stand for anything else.
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
    facets touch it, half of what they would lack is too much; and so, in their own way, with what they take in at
    concave faces: bars take in both places, for either kind of faces. Edges of more than 65 degrees are meant as they
    are: no bar speaks of them.

    Args:
        masses: of the mesh, wound outwards, about its centre.
        integrals: of the same mesh, of either winding. centre: (3,) of its mass, in units of the file.
        fixed_mass: the bars of the inertia are those at a given mass, not at a given density.

    Accuracy: in the documentation, by kind of solid (`tests/accuracy/test_tessellation_bars.py`).
    """
    if not len(masses.missing):
        return Tessellation(integrals, EXACT, EXACT, EXACT)
    V = abs(integrals.volume)
    arm = integrals.first / integrals.volume
    body = _Body(V, np.sign(integrals.volume) * integrals.S - V * np.outer(arm, arm), fixed_mass)
    parts = [_moments(masses, np.maximum(side * masses.missing, 0.0) * side) for side in (1, -1)]
    given, on = body.smooth(parts, 0, 0), body.smooth(parts, 1, 1)
    places = [body.smooth(parts, one, other) for one in (1, -OUTSIDE) for other in (1, -OUTSIDE)]
    doubt, lean, spread = _moments(masses, masses.doubt)
    shift = (length(lean) + SHIFT * _reach(masses)) / min(one.volume for one in (given, *places))
    doubts = np.array([doubt, _largest(spread) + (_largest(body.S) * doubt / V if fixed_mass else 0.0), shift])
    volume, first, second = (one + other for one, other in zip(*parts, strict=True))
    return Tessellation(
        _corrected(integrals, volume, first, second, centre),
        mesh=_bars(given, places, doubts),
        rest=_bars(on, places, doubts),
        on_surface=_bars(on, [on], doubts),
    )


@dataclass(frozen=True, eq=False)
class _Smooth:
    """Volume, second moments and centre of a smooth body, about the centre of the mesh."""

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
        """The smooth body with so many times what facets lack and what they take in too much, if corners are on it."""
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


def _reach(masses: LineMasses) -> float:
    """Return the doubt of edges times their distance from the centre, in sum."""
    middle = (masses.start + masses.end) / 2
    return float((masses.doubt * np.sqrt((middle * middle).sum(axis=0))).sum())


def _moments(masses: LineMasses, weights: Floats) -> tuple[float, Floats, Floats]:
    """Sums over edges of the integrals of 1, x and x x^T, for weights that are spread evenly along them.

    Of the weight m between p and q: m, m s / 2 and m (p p^T + q q^T + s s^T) / 6, with s = p + q.
    """
    p, q = masses.start, masses.end
    s = p + q
    second = sum(product(x * weights, x.T) for x in (p, q, s))
    return float(weights.sum()), product(s, weights) / 2, np.asarray(second) / 6


def _corrected(integrals: Integrals, volume: float, first: Floats, second: Floats, centre: Array) -> Integrals:
    """Return the integrals with what lies about the centre."""
    sign, arm = np.sign(integrals.volume), centre - integrals.reference
    across = np.outer(first, arm)
    return replace(
        integrals,
        volume=integrals.volume + sign * volume,
        first=integrals.first + sign * (first + volume * arm),
        S=integrals.S + sign * (second + across + across.T + volume * np.outer(arm, arm)),
        unrounded=None,
    )


def _largest(S: Floats) -> float:
    return float(np.abs(eigen(inertia_matrix(S))[0]).max())
