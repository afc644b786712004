"""Meshes whose unit was mistaken."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, partial
from math import dist

from robodyn.checks.context import Context
from robodyn.checks.meshes.files import MeshName, MeshUse, all_facts, mesh_names
from robodyn.robot.urdf.view import GeometryView, LinkView

_LONGEST, _SHORTEST = 20.0, 1e-3
"""Metres beyond which no part of a robot is; and, for such ones, of its sizes over the reach of the robot's joints."""
_TIMES, _MINUTE = 20.0, 100.0
_TWIN = (300.0, 3000.0)
"""Ratio of a link's meshes that a factor of 1000 between them explains."""
_UNEVEN = (900.0, 1100.0)
_KILOMETRES = 900.0
"""A scale in all axes that no file asks for: of 86 published robots none has more than 1."""


@dataclass(frozen=True, slots=True)
class UnitSlip:
    """A mesh as it is used: its longest side [m], or that of its scale where the file is not known, the factor of its
    size, and how that shows."""

    name: MeshName
    longest: float
    factor: float
    how: str


def mesh_slips(context: Context) -> Mapping[GeometryView, UnitSlip]:
    """Return the uses of meshes that are 1000 times too large or too small."""
    around = reach(context)
    found: dict[GeometryView, UnitSlip] = {}
    twin = cache(partial(_twin, context))
    for name in context.once(mesh_names).values():
        for use in name.uses:
            side = longest(use.geometry, name.uri, context)
            if side is None:
                scale = min(map(abs, use.geometry.scale.or_default(1.0, 1.0, 1.0) or (1.0,)))
                if scale >= _KILOMETRES:
                    how = f"a scale of {scale:g} is for a file in kilometres"
                    found[use.geometry] = UnitSlip(name, scale, 1e3, how)
                continue
            mistaken = _mistaken(side, twin(use.link, use.geometry.kind), around)
            sizes = sorted(map(abs, use.geometry.scale.or_default(1.0, 1.0, 1.0) or (1.0,)))
            if mistaken is None and sizes[0] > 0 and _UNEVEN[0] <= sizes[-1] / sizes[0] <= _UNEVEN[1]:
                mistaken = sizes[-1] / sizes[0], "its scale differs by a factor of 1000 between axes"
            if mistaken is not None:
                found[use.geometry] = UnitSlip(name, side, *mistaken)
    return found


def longest(geometry: GeometryView, uri: str, context: Context) -> float | None:
    """Return the longest side of the box of a mesh, scaled [m]; None where it is not known."""
    known = context.once(all_facts).get(uri)
    scale = geometry.scale.or_default(1.0, 1.0, 1.0)
    if known is None or known.problem is not None or scale is None or not all(scale):
        return None
    return max(abs(factor) * (hi - lo) for factor, lo, hi in zip(scale, known.lo, known.hi, strict=True))


def _mistaken(side: float, twin: float | None, reach: float) -> tuple[float, str] | None:
    if side > _LONGEST and side > _TIMES * reach:
        return 1e3, f"it is {side:.4g} m long"
    if side < _SHORTEST and reach > _MINUTE * side:
        return 1e-3, f"it is {1e3 * side:.3g} mm long in a robot whose joints are up to {reach:.3g} m apart"
    if twin is None or not twin > 0:
        return None
    ratio = side / twin
    too_large = 0 < _TIMES * reach < max(side, twin)
    if _TWIN[0] <= ratio <= _TWIN[1] and too_large:
        return 1e3, f"it is {ratio:.0f} times as large as the link's other mesh"
    if _TWIN[0] <= 1 / ratio <= _TWIN[1] and not too_large:
        return 1e-3, f"it is {1 / ratio:.0f} times smaller than the link's other mesh"
    return None


def _twin(context: Context, link: LinkView, kind: str) -> float | None:
    """Return the longest side of the largest mesh of a link that is of another kind, collision or visual."""
    others = [MeshUse(link, other) for other in link.geometries if other.kind != kind]
    sides = [longest(other.geometry, other.uri, context) for other in others]
    return max((side for side in sides if side is not None), default=None)


def reach(context: Context) -> float:
    """Return the largest distance between the origins of neighbouring links [m]; 0 where there is none."""
    offsets = (joint.origin.xyz.or_default(0.0, 0.0, 0.0) for joint in context.view.joints)
    return max((dist(xyz, (0.0, 0.0, 0.0)) for xyz in offsets if xyz is not None), default=0.0)
