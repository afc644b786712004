"""Collision boxes, cylinders and spheres whose numbers are not those of what is seen."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np

from robodyn.checks.bodies.masses import STILL
from robodyn.checks.bodies.shapes import Solid, Solids, around_known, size_of
from robodyn.checks.context import Context
from robodyn.checks.meshes.units import reach
from robodyn.robot.urdf.view import GeometryView
from robodyn.solids.inertia.validity import Box

_LARGE, _SEEN = 20.0, 0.01
"""As many times as what is seen of the link, which is more than a mark [m], or as the robot's longest offset.

Of 2019 collision shapes of published robots with a visual, primitives are at most 1.4 times as large, but for two that
surround marks of 3 mm.
"""
_FITTING, _BETTER, _MUCH_BETTER = 0.2, 2.0, 3.0
"""Volume that a cylinder with its numbers exchanged shares with what is seen over that of both, and how many times that
as it stands; below twice that volume much more. Of the same shapes two get better at all, from 0.32 to 0.5."""


class Misfit(NamedTuple):
    """A collision shape, what is wrong with it, what to do, by how much [m or a ratio], and why, if that is known."""

    geometry: GeometryView
    what: str
    remedy: str
    measured: float
    bound: float
    cause: str | None = None


def misfit_of_primitive(
    felt: Sequence[GeometryView], own: Box | None, known: Solids, context: Context
) -> Misfit | None:
    """Return the collision primitive of a link that is far larger than what is seen (`own`), or the cylinder that is
    turned by exchanging its radius and length; None if there is none."""
    return next(chain(_enormous(felt, own, known, context), _exchanged(felt, own, known)), None)


def _enormous(felt: Sequence[GeometryView], own: Box | None, known: Solids, context: Context) -> Iterator[Misfit]:
    seen = reach(context) if own is None else size_of(own)
    for shape in felt:
        if shape not in known or shape.shape is None or shape.shape.tag == "mesh" or seen < _SEEN:
            continue
        ratio = size_of(known[shape].box) / seen
        if ratio > _LARGE:
            than = "the robot's longest offset between joints" if own is None else "what is seen of the link"
            what = f"its collision {shape.shape.tag} is {ratio:.3g} times as large as {than}"
            cause = "its numbers are in millimetres" if ratio / 1e3 < 2 * _BETTER and ratio > 100 else None
            yield Misfit(shape, what, "write its size in metres", ratio, _LARGE, cause)


def _exchanged(felt: Sequence[GeometryView], own: Box | None, known: Solids) -> Iterator[Misfit]:
    boxes = [known[shape].placed(STILL) if shape in known else None for shape in felt]
    all_felt = around_known(boxes)
    if own is None or all_felt is None:
        return
    as_is = shared(own, all_felt)
    for k, shape in enumerate(felt):
        if shape.shape is None or shape.shape.tag != "cylinder":
            continue
        other = around_known([*boxes[:k], _exchange(known[shape]).placed(STILL), *boxes[k + 1 :]])
        fit = 0.0 if other is None else shared(own, other)
        better = _BETTER if fit >= 2 * _FITTING else _MUCH_BETTER
        if fit >= max(_FITTING, better * as_is):
            what = (
                "its collision cylinder fits what is seen with radius and length exchanged: their boxes then share "
                f"{fit:.0%}, as it stands {as_is:.0%}"
            )
            remedy = f'write radius="{shape.shape.get("length")}" length="{shape.shape.get("radius")}"'
            yield Misfit(shape, what, remedy, as_is, fit, "radius and length are exchanged")


def _exchange(solid: Solid) -> Solid:
    """Return the cylinder whose radius is this one's length, and its length this one's radius."""
    x, _, z = solid.box.hi
    half = np.array((2 * z, 2 * z, x / 2))
    return Solid(Box(-half, half), solid.pose)


def shared(first: Box, second: Box) -> float:
    """Return the volume that two boxes share over that of both together."""
    sides = np.minimum(first.hi, second.hi) - np.maximum(first.lo, second.lo)
    if (sides <= 0).any():
        return 0.0
    both = float(sides.prod())
    return both / (float((first.hi - first.lo).prod()) + float((second.hi - second.lo).prod()) - both)
