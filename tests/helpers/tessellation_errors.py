"""True errors of tessellated solids before and after their correction, beside their bars."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from helpers import mesh_samples as samples
from helpers.mesh_oracle import rotation
from helpers.smooth_solids import Solid, solids
from robodyn.solids.mesh.asymmetry import CentredBody
from robodyn.solids.mesh.integrals import Integrals, integrate
from robodyn.solids.mesh.read.load import from_array
from robodyn.solids.mesh.tessellation import Tessellation, tessellation


@dataclass(frozen=True)
class Case:
    """Errors relative to the exact volume, and to the largest exact moment of inertia."""

    solid: str
    facets: int
    triangles: int
    volume: float
    volume_corrected: float
    inertia: float
    inertia_corrected: float
    found: Tessellation

    @property
    def ratio(self) -> float:
        return self.inertia / self.inertia_corrected

    @property
    def covered(self) -> tuple[bool, bool]:
        """Whether the bars of the mesh's numbers hold, and those of the corrected ones, all corners being in place."""
        mesh, rest = self.found.mesh, self.found.on_surface
        return (
            self.volume <= mesh.volume and self.inertia <= mesh.inertia,
            self.volume_corrected <= rest.volume and self.inertia_corrected <= rest.inertia,
        )


def estimated(corners: np.ndarray, fixed_mass: bool = False) -> tuple[Integrals, Tessellation]:
    triangles = from_array(corners)
    integrals = integrate(triangles)
    body = CentredBody.of(triangles, integrals)
    return integrals, tessellation(body.line_masses, integrals, body.centre, fixed_mass=fixed_mass)


def case(solid: Solid, facets: int, seed: int, fixed_mass: bool = False) -> Case:
    """Of a solid in any pose."""
    R = rotation(seed)
    corners = samples.moved(solid.mesh(facets), np.random.default_rng(seed).normal(size=3), R)
    integrals, found = estimated(corners, fixed_mass)
    exact = R @ solid.S @ R.T
    errors = []
    for part in (integrals, found.corrected):
        S = part.S - np.outer(part.first, part.first) / part.volume
        scale = solid.volume / part.volume if fixed_mass else 1.0
        errors.append((abs(part.volume / solid.volume - 1), _largest(S * scale - exact) / _largest(exact)))
    (volume, inertia), (volume_corrected, inertia_corrected) = errors
    return Case(solid.name, facets, len(corners), volume, volume_corrected, inertia, inertia_corrected, found)


def cases(resolutions: tuple[int, ...], poses: int = 1, fixed_mass: bool = False) -> Iterator[Case]:
    for solid in solids():
        for facets in resolutions:
            yield from (case(solid, facets, seed, fixed_mass) for seed in range(poses))


def _largest(S: np.ndarray) -> float:
    return float(np.abs(np.linalg.eigvalsh(np.trace(S) * np.eye(3) - S)).max())
