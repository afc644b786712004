"""True errors of the mass properties of round meshes, over their bars."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from helpers.round_shapes import Round
from helpers.tessellation_errors import estimated
from robodyn.solids.inertia.laws import inertia_matrix
from robodyn.solids.mesh.integrals import Integrals
from robodyn.solids.mesh.tessellation import Bars

MEASURES = "volume", "inertia", "centre"
EPS = 1e-9
"""Relative errors that rounding may make."""


@dataclass(frozen=True)
class Errors:
    """(3,) true errors over the bars, by `MEASURES`: of the mesh, of the corrected numbers, and of these if corners
    are on the surface; infinite bars hold. unknown: (2,) whether some bar of the mesh, of the
    corrected numbers is."""

    mesh: np.ndarray
    rest: np.ndarray
    on_surface: np.ndarray
    unknown: np.ndarray


def errors(solid: Round, fixed_mass: bool = False) -> Errors:
    whole, found = estimated(solid.corners, fixed_mass)
    mesh, smooth = (_true(one, solid, fixed_mass) for one in (whole, found.corrected))
    bars = found.mesh, found.rest, found.on_surface
    unknown = [not np.isfinite((one.volume, one.inertia, one.centre)).all() for one in bars[:2]]
    return Errors(*map(_over, (mesh, smooth, smooth), bars), np.array(unknown))


def _true(found: Integrals, solid: Round, fixed_mass: bool) -> np.ndarray:
    """Errors relative to the solid."""
    arm = found.first / found.volume
    S = found.S - np.outer(arm, found.first)
    if fixed_mass:
        S = S * (solid.volume / found.volume)
    size = _largest(solid.S)
    centre = np.linalg.norm(found.reference + arm - solid.com) / (size / solid.volume) ** 0.5
    return np.array([abs(found.volume / solid.volume - 1), _largest(S - solid.S) / size, centre])


def _over(true: np.ndarray, bars: Bars) -> np.ndarray:
    return true / (np.array([bars.volume, bars.inertia, bars.centre]) + EPS)


def _largest(S: np.ndarray) -> float:
    return float(np.abs(np.linalg.eigvalsh(inertia_matrix(S))).max())
