"""How the collision shapes of a link fit what is seen of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.checks.bodies.masses import STILL
from robodyn.checks.bodies.shapes import Solid, Solids, around_known, box_of, real_shapes, size_of, solids
from robodyn.checks.context import Context
from robodyn.checks.meshes.units import reach
from robodyn.programs.vectors import length
from robodyn.robot.urdf.view import GeometryView, LinkView
from robodyn.solids.inertia.validity import Box
from robodyn.support.floats import Floats

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


Mask = NDArray[np.bool_]

_ALIKE = 0.1
"""Sides of the boxes of two meshes of one part differ by less: one may be simplified."""
_ASIDE, _LEAST = 0.15, 0.01
"""Of the size of a shape, and in metres: as far the collision shape is away at least."""
_APART = 0.5
"""Of the larger of two different shapes: a gap as wide is between them."""
_OTHER, _OWN = 0.8, 0.5
"""Shared volume of the boxes over that of both: at least with another link's visual, and at most with its own.

Of 1388 links of published robots with meshes for both, 12 have less than 0.4 (each has a collision mesh that stands
elsewhere), and 1360 more than 0.8.
"""
_UNLIKE = 0.2
"""Shared volume at most of one mesh each for both, whatever else it fits: of the same links 10, all of them found by
where they stand; the next has 0.22."""
_SCALED, _EVEN = 1.25, 1.05
"""Least factor between sizes, and how far it may differ between axes."""


def misfits(context: Context) -> tuple[Misfit, ...]:
    """Return at most one collision shape of each link that is not that of what is seen."""
    return tuple(_misfits(context))


def _misfits(context: Context) -> Iterator[Misfit]:
    known = context.once(solids)
    visual = cache(lambda link: box_of(_of_kind(link, "visual"), known, STILL))
    for link in context.view.links:
        felt = _of_kind(link, "collision")
        box = box_of(felt, known, STILL)
        own = visual(link) if felt else None
        if not felt or (len(felt) == 1 and own and box and _corner(own, box) <= max(_ASIDE * size_of(own), _LEAST)):
            continue
        found = _foreign(link, felt, visual, context) if own and box and shared(own, box) <= _OWN else None
        found = found or _aside(link, felt, context) or _scaled(link, felt, context)
        found = found or misfit_of_primitive(felt, own, known, context) or _away(felt, own, context)
        found = found or _unlike(felt, _of_kind(link, "visual"), own, box)
        if found is not None:
            yield found


def _of_kind(link: LinkView, kind: str) -> list[GeometryView]:
    return [shape for shape in real_shapes(link) if shape.kind == kind]


def _foreign(
    link: LinkView, felt: Sequence[GeometryView], visual: Callable[[LinkView], Box | None], context: Context
) -> Misfit | None:
    """Find a collision mesh that fits what is seen of another link; it does not fit its own."""
    own, box = visual(link), box_of(felt, context.once(solids), STILL)
    if own is None or box is None or not all(map(_is_mesh, felt)):
        return None
    fit = shared(own, box)
    others = [(other.name, shared(seen, box)) for other in context.view.links if (seen := visual(other)) is not None]
    name, best = max(others, key=lambda each: each[1])
    if best < _OTHER:
        return None
    what = f"its collision shape is that of link '{name}': their boxes share {best:.0%}, with its own visual {fit:.0%}"
    return Misfit(felt[0], what, "name the mesh of this link", fit, _OWN)


def _aside(link: LinkView, felt: Sequence[GeometryView], context: Context) -> Misfit | None:
    """Find the shape that is seen, too, at another place."""
    known = context.once(solids)
    seen, felt = ([each for each in shapes if each in known] for shapes in (_of_kind(link, "visual"), felt))
    if not seen:
        return None
    places = np.array([(box.lo, box.hi) for box in (known[each].placed(STILL) for each in seen)])
    of_seen, of_felt = _kinds_and_sides(seen, context), _kinds_and_sides(felt, context)
    for k, shape in enumerate(felt):
        twins = np.flatnonzero(_same(k, of_felt, of_seen))
        if not 0 < np.count_nonzero(_same(k, of_felt, of_felt)) <= len(twins):
            continue
        box = known[shape].placed(STILL)
        away = float(np.linalg.norm(places[twins] - (box.lo, box.hi), axis=2).max(axis=1).min())
        if away > max(_ASIDE * size_of(box), _LEAST):
            what = f"its collision {_named(shape)} is not where its visual is, but up to {away:.3g} m from there"
            return Misfit(shape, what, "give both the same <origin>", away, _ASIDE * size_of(box))
    return None


def _scaled(link: LinkView, felt: Sequence[GeometryView], context: Context) -> Misfit | None:
    """Find a mesh of another size than the same mesh, or the link's only one, that is seen."""
    known = context.once(solids)
    seen = [shape for shape in _of_kind(link, "visual") if _is_mesh(shape)]
    for shape in felt:
        twins = [other for other in seen if _file(other) == _file(shape)] or (seen if len(felt) == 1 else [])
        if not _is_mesh(shape) or shape not in known or len(twins) != 1 or twins[0] not in known:
            continue
        sides, own = _sides(shape, context), _sides(twins[0], context)
        if not (sides > 0).all() or not (own > 0).all():
            continue
        ratios = sides / own
        factor = float(ratios.prod()) ** (1 / 3)
        if max(factor, 1 / factor) >= _SCALED and ratios.max() <= _EVEN * ratios.min():
            what = f"its collision mesh is {factor:.3g} times as large as its visual, in all three axes"
            return Misfit(shape, what, "give both the same scale", factor, 1.0)
    return None


def _away(felt: Sequence[GeometryView], own: Box | None, context: Context) -> Misfit | None:
    """Find a shape that has a wide gap to all that is seen."""
    known = context.once(solids)
    for shape in felt:
        if own is None or shape not in known:
            continue
        box = known[shape].placed(STILL)
        gap = length(np.maximum(np.maximum(own.lo - box.hi, box.lo - own.hi), 0.0))
        bound = max(_APART * max(size_of(own), size_of(box)), _LEAST)
        if gap > bound:
            what = f"there are {gap:.3g} m between its collision {_named(shape)} and its visual"
            return Misfit(shape, what, "check the <origin> of both", gap, bound)
    return None


def _unlike(
    felt: Sequence[GeometryView], seen: Sequence[GeometryView], own: Box | None, box: Box | None
) -> Misfit | None:
    """Find a collision mesh that is hardly where the visual one is: it is turned, or one of them is another part's."""
    if own is None or box is None or not (len(felt) == len(seen) == 1 and _is_mesh(felt[0]) and _is_mesh(seen[0])):
        return None
    fit = shared(own, box)
    if fit > _UNLIKE:
        return None
    what = f"its collision mesh is not the part that its visual is: their boxes share {fit:.0%}"
    return Misfit(
        felt[0], what, "check the <origin> of both, and that neither is the mesh of another link", fit, _UNLIKE
    )


def _is_mesh(shape: GeometryView) -> bool:
    return shape.shape is not None and shape.shape.tag == "mesh"


def _kinds_and_sides(shapes: Sequence[GeometryView], context: Context) -> tuple[NDArray[np.str_], Floats]:
    """Return the kinds (n,) and the sides (n, 3), see `_sides`, of shapes that are known."""
    sides = np.array([_sides(shape, context) for shape in shapes]).reshape(-1, 3)
    return np.array([_named(shape) for shape in shapes], np.str_), sides


def _same(k: int, among: tuple[NDArray[np.str_], Floats], others: tuple[NDArray[np.str_], Floats]) -> Mask:
    """(n,) which others are of the kind and size of shape k; meshes may be simplified."""
    (kinds, sides), (others_kinds, others_sides) = among, others
    slack = _ALIKE if kinds[k] == "mesh" else 1e-2
    near = np.abs(others_sides - sides[k]) <= slack * np.maximum(others_sides, sides[k])
    found: Mask = (others_kinds == kinds[k]) & near.all(axis=1)
    return found


def _sides(shape: GeometryView, context: Context) -> Floats:
    """Return (3,) the sides of its box in its own axes, ascending [m]; of a shape that is known."""
    box = context.once(solids)[shape].box
    return np.sort(box.hi - box.lo)


def _file(shape: GeometryView) -> str | None:
    return None if shape.shape is None else shape.shape.get("filename")


def _named(shape: GeometryView) -> str:
    return "" if shape.shape is None else shape.shape.tag


def _corner(first: Box, second: Box) -> float:
    """Return the larger of the distances between their corners [m]."""
    return max(length(first.lo - second.lo), length(first.hi - second.hi))
