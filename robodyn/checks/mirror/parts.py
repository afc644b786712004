"""One part on both sides: what carries the meshes of a left link onto those of the right one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robodyn.programs.vectors import length, product
from robodyn.robot.load import placement
from robodyn.robot.urdf.parts import Geometry, Link
from robodyn.support.floats import Floats

_SAME = 1e-4
"""How far the meshes of one part may be carried differently: entries of G, and of p [m]."""


@dataclass(frozen=True, eq=False)
class Carried:
    """The isometry x -> G x + p from the axes of the left link to those of the right; det G = -1 if a scale is negative
    on one side."""

    G: Floats
    p: Floats

    def point(self, x: Floats) -> Floats:
        moved: Floats = product(self.G, x) + self.p
        return moved


def carried(left: Link, right: Link, D: Floats, still: bool = False) -> Carried | None:
    """Return what carries the meshes of one link onto those of the other; None unless they are the same files, placed
    alike to each other.

    The <visual> ones count, since collision meshes are simplified, to something symmetric even; or the <collision> ones
    where there are no others. Links without meshes are one part if their primitives stand at the same places, and these
    are not each other's images, or both links are fixed: then it is most often a sensor that was bought twice.

    Args:
        D: (3, 3) the reflection from the axes of the left link to those of the right.
        still: whether both links are fixed to what carries them.
    """
    for kind in ("visual", "collision"):
        one, other = ([shape for shape in link.geometries if shape.kind == kind] for link in (left, right))
        meshes = [[shape for shape in shapes if shape.shape == "mesh"] for shapes in (one, other)]
        if any(meshes):
            return _common(*meshes)
        if one or other:
            return _in_place(one, other, D, still)
    return None


def _in_place(one: list[Geometry], other: list[Geometry], D: Floats, fixed: bool) -> Carried | None:
    if [(shape.shape, shape.size, shape.origin) for shape in one] != [
        (shape.shape, shape.size, shape.origin) for shape in other
    ]:
        return None
    places = [np.array(shape.origin.xyz) for shape in one]
    still = all(length(product(D, place) - place) <= _SAME for place in places)
    return None if still and not fixed else Carried(np.eye(3), np.zeros(3))


def _common(one: list[Geometry], other: list[Geometry]) -> Carried | None:
    if [mesh.filename for mesh in one] != [mesh.filename for mesh in other]:
        return None
    moves = [_move(*meshes) for meshes in zip(one, other, strict=True)]
    first = moves[0]
    return first if all(_alike(first, move) for move in moves) else None


def _move(one: Geometry, other: Geometry) -> Carried | None:
    """Return G = R' diag(s' / s) R^T and p = x' - G x; None where the scales differ in more than signs."""
    scales = zip(one.scale, other.scale, strict=True)
    if not all(s and abs(abs(s) - abs(s_other)) <= 1e-6 * abs(s) for s, s_other in scales):
        return None
    if (one.origin, one.scale) == (other.origin, other.scale):
        return Carried(np.eye(3), np.zeros(3))
    (R, x), (R_other, x_other) = placement(one.origin), placement(other.origin)
    G = product(R_other, np.diag(np.sign(other.scale) * np.sign(one.scale)), R.T)
    return Carried(G, x_other - product(G, x))


def _alike(one: Carried | None, other: Carried | None) -> bool:
    if one is None or other is None:
        return False
    return float(np.abs(one.G - other.G).max()) <= _SAME and length(one.p - other.p) <= _SAME
