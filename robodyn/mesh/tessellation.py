"""What a body of facets leaves out of the smooth one it may stand for: corrected integrals, and error bars."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robodyn.inertia.second import inertia_matrix
from robodyn.mesh.integrals import Integrals
from robodyn.mesh.tessellation_edges import Floats
from robodyn.mesh.tessellation_lines import LineMasses
from robodyn.spatial import Array


@dataclass(frozen=True)
class Bars:
    """How far numbers may be from those of the smooth body.

    Attributes:
        volume: relative to the volume of the mesh.
        inertia: of the largest error among all axes through the centre, relative to the largest principal moment.
    """

    volume: float
    inertia: float


@dataclass(frozen=True, eq=False)
class Tessellation:
    """Integrals over the smooth body that a mesh may stand for.

    Attributes:
        corrected: those of the mesh with what its facets leave out; the same object where none stand for anything else.
        mesh, rest: bars of the mesh's own integrals, and of the corrected ones.
    """

    corrected: Integrals
    mesh: Bars
    rest: Bars


def tessellation(masses: LineMasses, integrals: Integrals, centre: Array, *, fixed_mass: bool = False) -> Tessellation:
    """Line masses added to the volume, first and second moments of a mesh.

    The bar of the corrected numbers is the doubt of all edges added up; that of the mesh's own is the correction and
    this. Edges of more than 40 degrees are meant as they are: no bar speaks of them.

    Args:
        masses: of the mesh, wound outwards, about its centre.
        integrals: of the same mesh, of either winding. centre: (3,) of its mass, in units of the file.
        fixed_mass: the bars of the inertia are those at a given mass, not at a given density.

    Accuracy: on cylinders, cones, tori, balls, capsules and drilled or filleted plates of 12 to 128 facets to a turn
        the error of the inertia falls to less than a twentieth in the median, and the bars hold in at least 95 %.
    """
    if not len(masses.missing):
        return Tessellation(integrals, Bars(0.0, 0.0), Bars(0.0, 0.0))
    V = abs(integrals.volume)
    volume, first, second = _moments(masses, masses.missing)
    doubt, _, spread = _moments(masses, masses.doubt)
    arm = integrals.first / integrals.volume
    S = np.sign(integrals.volume) * integrals.S - V * np.outer(arm, arm)
    change, slack = second - np.outer(first, first) / V, _largest(spread)
    if fixed_mass:
        change, slack = change - S * (volume / V), slack + _largest(S) * doubt / V
    size = _largest(S)
    rest = Bars(doubt / V, slack / size)
    mesh = Bars((abs(volume) + doubt) / V, (_largest(change) + slack) / size)
    return Tessellation(_corrected(integrals, volume, first, second, centre), mesh, rest)


def _moments(masses: LineMasses, weights: Floats) -> tuple[float, Floats, Floats]:
    """Sums over edges of the integrals of 1, x and x x^T, for weights that are spread evenly along them.

    Of the weight m between p and q: m, m s / 2 and m (p p^T + q q^T + s s^T) / 6, with s = p + q.
    """
    p, q = masses.start, masses.end
    s = p + q
    second = sum((x * weights) @ x.T for x in (p, q, s))
    return float(weights.sum()), s @ weights / 2, np.asarray(second) / 6


def _corrected(integrals: Integrals, volume: float, first: Floats, second: Floats, centre: Array) -> Integrals:
    """The integrals with what lies about the centre."""
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
    return float(np.abs(np.linalg.eigvalsh(inertia_matrix(S))).max())
