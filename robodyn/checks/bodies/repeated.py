"""Bodies whose mass is written twice, on links that are fixed to each other."""

from __future__ import annotations

from collections.abc import Mapping

from robodyn.checks.bodies.bodies import Body, bodies, share
from robodyn.checks.context import Context
from robodyn.programs.vectors import length
from robodyn.robot.urdf.view import JointView, LinkView

_MASS = 1e-6
"""Relative difference of masses that are the same."""
_NEAR = 1e-3
"""Metres between centres of mass that are the same."""


def repeated(context: Context) -> Mapping[str, JointView]:
    """Return by child the fixed joints whose child has the mass of its parent again."""
    known = context.once(bodies)
    found = {}
    for joint in context.view.joints:
        part, again = known.get(joint.parent), known.get(joint.child)
        if joint.type != "fixed" or part is None or again is None or abs(part.mass - again.mass) > _MASS * part.mass:
            continue
        if share(context, again) is not None and (_one_centre(part, again) or _copied(part, again)):
            found[joint.child] = joint
    return found


def _one_centre(part: Body, again: Body) -> bool:
    """Return whether both have a spread, and their centres of mass are at one point."""
    spread = not _stand_in(part) and not _stand_in(again)
    return spread and length(part.in_group[0] - again.in_group[0]) <= _NEAR


def _copied(part: Body, again: Body) -> bool:
    """Return whether the numbers of one are those of the other, which has no shape, or products of inertia and another
    shape."""
    tensor = part.link.tensor
    same = tensor == again.link.tensor and bool((part.c == again.c).all()) and not _stand_in(part)
    if not same or tensor is None or not again.link.geometries:
        return same
    return all(tensor[k] for k in (1, 2, 4)) and _shapes(part.link) != _shapes(again.link)


def _shapes(link: LinkView) -> set[tuple[tuple[str, str], ...]]:
    return {tuple(sorted(shape.shape.values.items())) for shape in link.geometries if shape.shape is not None}


def _stand_in(body: Body) -> bool:
    tensor = body.link.tensor
    return tensor is None or tensor[0] == tensor[3] == tensor[5]
