"""True errors of the mass properties of meshes of smooth solids, of corrected ones, and both over their bars."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from helpers.round_shapes import Round
from robodyn.solids.inertia.laws import inertia_matrix
from robodyn.solids.mesh.asymmetry import CentredBody
from robodyn.solids.mesh.integrals import Integrals, integrate
from robodyn.solids.mesh.read.load import from_array
from robodyn.solids.mesh.tessellation import Bars, Tessellation, tessellation

EPS = 1e-9
"""Relative errors that rounding may make."""


class Errors(NamedTuple):
    """(3,) true relative errors of volume, inertia and centre, of the mesh and of the corrected numbers; the bars."""

    mesh: np.ndarray
    corrected: np.ndarray
    found: Tessellation

    def over(self, bars: Bars) -> np.ndarray:
        """(3,) over the bars of the mesh or of the corrected numbers; infinite bars hold."""
        true = self.mesh if bars is self.found.mesh else self.corrected
        return true / (np.array([bars.volume, bars.inertia, bars.centre]) + EPS)


def estimated(corners: np.ndarray, fixed_mass: bool = False) -> tuple[Integrals, Tessellation]:
    triangles = from_array(corners)
    integrals = integrate(triangles)
    body = CentredBody.of(triangles, integrals)
    return integrals, tessellation(body.line_masses, integrals, body.centre, fixed_mass=fixed_mass)


def errors(solid: Round, fixed_mass: bool = False) -> Errors:
    whole, found = estimated(solid.corners, fixed_mass)
    return Errors(*(_true(one, solid, fixed_mass) for one in (whole, found.corrected)), found)


def _true(found: Integrals, solid: Round, fixed_mass: bool) -> np.ndarray:
    arm = found.first / found.volume
    S = found.S - np.outer(arm, found.first)
    if fixed_mass:
        S = S * (solid.volume / found.volume)
    size = _largest(solid.S)
    centre = np.linalg.norm(found.reference + arm - solid.com) / (size / solid.volume) ** 0.5
    return np.array([abs(found.volume / solid.volume - 1), _largest(S - solid.S) / size, centre])


def _largest(S: np.ndarray) -> float:
    return float(np.abs(np.linalg.eigvalsh(inertia_matrix(S))).max())
