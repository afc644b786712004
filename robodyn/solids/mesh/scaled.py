"""Triangles stretched along their axes, as <mesh scale="..."> of URDF asks for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robodyn.errors import MeshError
from robodyn.solids.mesh.triangles import BLOCK, Corners, Floats, Triangles


@dataclass(frozen=True, eq=False)
class ScaledTriangles:
    """The given triangles with each coordinate times its factor, and `common` times their scale; see `Triangles`.

    Of a mirror image the corners are read backwards, so that what was wound outwards still is.
    """

    given: Triangles
    common: float
    factors: Floats

    @property
    def name(self) -> str:
        return self.given.name

    @property
    def count(self) -> int:
        return self.given.count

    @property
    def significand(self) -> int:
        return self.given.significand

    @property
    def scale(self) -> float:
        return self.given.scale * self.common

    @property
    def notes(self) -> tuple[str, ...]:
        return self.given.notes

    @property
    def warnings(self) -> tuple[str, ...]:
        return self.given.warnings

    def blocks(self, rows: int = BLOCK) -> Iterator[Corners]:
        for block in self.given.blocks(rows):
            yield self._stretched(block)

    def array(self) -> Floats:
        return self._stretched(self.given.array()).astype(np.float64, copy=False)

    def _stretched(self, corners: Corners) -> Corners:
        if (self.factors == 1).all():
            return corners
        stretched = corners * self.factors
        return stretched[:, ::-1] if self.factors.prod() < 0 else stretched


def scaled(triangles: Triangles, factors: Sequence[float]) -> Triangles:
    """The triangles stretched along x, y and z; the same object where all three factors are 1.

    What the factors have in common goes into the scale, so that a change of unit changes no coordinate.

    Args:
        factors: (3,), negative ones for mirror images.

    Raises:
        MeshError: a factor is zero or not finite.
    """
    given = np.array(factors, dtype=float)
    if not (np.isfinite(given) & (given != 0)).all():
        listed = " ".join(f"{factor:g}" for factor in given)
        raise MeshError(
            f"the scale {listed} leaves no volume", remedy="give factors that are not zero", file=triangles.name
        )
    if (given == 1).all():
        return triangles
    common = float(abs(given[0]))
    return ScaledTriangles(triangles, common, given / common)
