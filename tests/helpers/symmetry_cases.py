"""Bodies of which it is known in which planes they are symmetric, and verdicts that are false."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from helpers import mesh_samples as samples
from helpers.mesh_oracle import rotation
from helpers.smooth_solids import solids
from helpers.symmetric_bodies import found
from robodyn.solids.mesh.asymmetry import CentredBody
from robodyn.solids.mesh.integrals import integrate
from robodyn.solids.mesh.read.load import from_array
from robodyn.solids.mesh.symmetry_search import Symmetry

ROUND = ["cylinder", "tube", "capsule", "ball", "rounded disc", "pulley", "torus"]
PLANES = dict.fromkeys(ROUND, "xyz") | {
    "cone": "xy",
    "half ball": "xy",
    "ellipsoid": "xyz",
    "ball of equal triangles": "xyz",
    "plate with a hole": "z",
    "bracket": "z",
    "lever": "yz",
    "rounded box": "xyz",
    "box with small fillets": "xyz",
}
FINE = 4e-3
"""More of the volume than this is not left out: above an asymmetry of 0.01 nothing holds, whatever the facets."""
CLEAR = 4.0
"""A box off the planes takes this many times the volume that facets may leave out."""


@dataclass(frozen=True, eq=False)
class Body:
    """Corners, and the normals of planes that hold and of planes that do not, as rows."""

    name: str
    corners: np.ndarray
    holding: np.ndarray
    broken: np.ndarray

    def false_verdicts(self) -> tuple[int, int]:
        """How many planes are told wrong, of how many."""
        verdict = found(self.corners)
        missed = sum(not _holds(verdict, normal) for normal in self.holding)
        invented = sum(_holds(verdict, normal) for normal in self.broken)
        return missed + invented, len(self.holding) + len(self.broken)


def bodies(count: int, seed: int = 0) -> Iterator[Body]:
    """In any pose and size, every other one in float32."""
    rng = np.random.default_rng(seed)
    for k in range(count):
        name, corners, planes = _body(rng)
        if rng.random() < 0.5:
            corners, planes, name = _beside(corners, rng), "", f"{name} with a box off the planes"
        R = rotation(int(rng.integers(1 << 30)))
        offset, size = rng.normal(size=3), 10.0 ** rng.uniform(-3, 3)
        placed = samples.moved(corners, offset, R) * size
        placed = placed if k % 2 else placed.astype(np.float32).astype(float)
        holds = np.array([axis in planes for axis in "xyz"])
        yield Body(name, placed, R.T[holds], R.T[~holds])


def _body(rng: np.random.Generator) -> tuple[str, np.ndarray, str]:
    solid = rng.choice([one for one in solids() if one.name in PLANES])
    facets = int(rng.integers(16, 49))
    while _lacking(solid.mesh(facets)) > FINE:
        facets *= 2
    return solid.name, solid.mesh(facets), PLANES[solid.name]


def _lacking(corners: np.ndarray) -> float:
    """What facets leave out, as a part of the volume."""
    triangles = from_array(corners)
    return CentredBody.of(triangles, integrate(triangles)).facets


def _beside(corners: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """With a box beside it, off all planes of the axes, clearly larger than what facets leave out."""
    share = max(CLEAR * _lacking(corners), 10 ** rng.uniform(-4, -2))
    edge = (share * integrate(from_array(corners)).volume) ** (1 / 3)
    place = corners.max(axis=(0, 1)) + edge * rng.uniform(0.6, 1.5, 3)
    return np.concatenate([corners, samples.moved(samples.box((edge, edge, edge)), place)])


def _holds(verdict: Symmetry, normal: np.ndarray) -> bool:
    """A plane near this normal holds, or an axis of revolution in that plane, or two such axes: a ball."""
    planes = [plane.normal for plane in verdict.planes if plane.holds]
    axes = [axis.direction for axis in verdict.axes if axis.holds and axis.fold == np.inf]
    near = any(np.linalg.norm(np.cross(n, normal)) < 0.02 for n in planes)
    return near or len(axes) > 1 or any(abs(d @ normal) < 0.02 for d in axes)
