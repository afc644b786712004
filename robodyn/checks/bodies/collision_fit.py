"""How the collision shapes of a link fit what is seen of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from itertools import chain, islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robodyn.checks.bodies.bodies import Solid, Solids, box_of, gap, real_shapes, size_of, solids
from robodyn.checks.bodies.masses import STILL
from robodyn.checks.context import Context
from robodyn.checks.meshes.files import all_facts, reach
from robodyn.programs.vectors import length
from robodyn.robot.urdf.view import GeometryView, LinkView
from robodyn.solids.inertia.validity import Box, around
from robodyn.support.floats import Floats

_LARGE, _SEEN = 20.0, 0.01
"""As many times as what is seen of the link, which is more than a mark [m], or as the robot's longest offset.

Of 2019 collision shapes of published robots with a visual, primitives are at most 1.4 times as large, but for two that
surround marks of 3 mm.
"""
_FITTING, _BETTER, _MUCH_BETTER = 0.2, 2.0, 3.0
"""Volume that a cylinder with its numbers exchanged shares with what is seen over that of both, and how many times that
as it stands; below twice that volume much more. Of the same shapes two get better at all, from 0.32 to 0.5."""
_ALIKE = 0.1  # sides of the boxes of two meshes of one part differ by less: one may be simplified
_ASIDE, _LEAST = 0.15, 0.01  # of the size of a shape, and in metres: as far the collision shape is away at least
_TOGETHER, _NEARER = 0.03, 4.0
"""Of the size of a mesh: corners of the box around what fits; and how many times farther those of what does not are."""
_APART = 0.5  # of the larger of two different shapes: a gap as wide is between them
_OTHER, _OWN = 0.8, 0.5
"""Shared volume of the boxes over that of both: at least with another link's visual, and at most with its own.

Of 1388 links of published robots with meshes for both, 12 have less than 0.4 (each has a collision mesh that stands
elsewhere), and 1360 more than 0.8.
"""
_UNLIKE = 0.2
"""Shared volume at most of one mesh each for both, whatever else it fits: of the same links 10, all of them found by
where they stand; the next has 0.22."""
_FINER, _FACES = 10, 12  # how many times the faces are much finer; those of a primitive
_SCALED, _EVEN = 1.25, 1.05  # least factor between sizes, and how far it may differ between axes


class Misfit(NamedTuple):
    """A collision shape, what is wrong with it, what to do, by how much [m or a ratio], and why, if that is known."""

    geometry: GeometryView
    what: str
    remedy: str
    measured: float
    bound: float
    cause: str | None = None


class _Link(NamedTuple):
    """A link, its collision shapes, `felt`, and visual ones, `seen`, and the boxes around both, None where one is
    unknown."""

    view: LinkView
    felt: Sequence[GeometryView]
    seen: Sequence[GeometryView]
    felt_box: Box | None
    seen_box: Box | None
    known: Solids


def misfits(context: Context) -> tuple[Misfit, ...]:
    """Return at most one collision shape of each link that is not what is seen."""
    known, found = context.once(solids), list[Misfit]()
    visual = cache(lambda link: box_of(real_shapes(link, "visual"), known, STILL))
    shapes = ((link, real_shapes(link, "collision"), real_shapes(link, "visual")) for link in context.view.links)
    links = [_Link(link, felt, seen, box_of(felt, known, STILL), visual(link), known) for link, felt, seen in shapes]
    order = [_simpler(one, context) if one.felt and one.seen else 0 for one in links]
    wrong, right = order.count(-1), order.count(1)
    for one, which in zip(links, order, strict=True):
        if which < 0 and 2 * wrong <= right:
            what = f"what collides is the finer part; of {right} other links it is what is seen"
            cause = "visual and collision are exchanged"
            found.append(Misfit(one.felt[0], what, "exchange the two", wrong, right / 2, cause))
            continue
        own, box = one.seen_box, one.felt_box
        fits = own and box and len(one.felt) == 1 and corners(own, box) <= max(_ASIDE * size_of(own), _LEAST)
        others = _foreign(one, visual, context), _aside(one), _scaled(one), _enormous(one, context), _exchanged(one)
        found += islice(chain(_origin_lost(one), *(() if fits else (*others, _away(one), _unlike(one)))), 1)
    return tuple(found)


def _simpler(one: _Link, context: Context) -> int:
    """1 where what collides is the simpler part by the names of its files, or else by far by its faces, -1 where what
    is seen is, 0 where neither is."""
    sides = one.felt, one.seen
    paths = ("".join(shape.uri.lower() for shape in shapes) for shapes in sides)
    felt, seen = (("collision" in path) - ("visual" in path) for path in paths)
    if felt == seen and one.felt_box and one.seen_box and shared(one.felt_box, one.seen_box) > _OWN:
        of = context.once(all_facts)
        faces = [sum(of[it.uri].triangles if it.tag == "mesh" else _FACES for it in shapes) for shapes in sides]
        felt, seen = faces[1] >= _FINER * faces[0], faces[0] >= _FINER * faces[1]
    return (felt > seen) - (felt < seen)


def corners(box: Box, other: Box) -> float:
    """How far two boxes are from each other by their corners, lo from lo and hi from hi, whichever is more [m]."""
    return max(length(box.lo - other.lo), length(box.hi - other.hi))


def _origin_lost(one: _Link) -> Iterator[Misfit]:
    """One mesh each for both, which fit each other where they have the same origin, and as it stands are apart."""
    if one.seen_box is None or one.felt_box is None or [shape.tag for shape in (*one.felt, *one.seen)] != ["mesh"] * 2:
        return
    alike = one.known[one.felt[0]]._replace(pose=one.known[one.seen[0]].pose).placed(STILL)
    now, then = (corners(one.seen_box, box) for box in (one.felt_box, alike))
    if now > _LEAST and then <= min(_TOGETHER * size_of(one.seen_box), now / _NEARER):
        what = f"its collision mesh is not where its visual is, but up to {now:.3g} m from there"
        yield Misfit(one.felt[0], what, "give both the same <origin>", now, _LEAST)


def _foreign(one: _Link, visual: Callable[[LinkView], Box | None], context: Context) -> Iterator[Misfit]:
    """A collision mesh that fits what is seen of another link; it does not fit its own."""
    own, box = one.seen_box, one.felt_box
    if own is None or box is None or (fit := shared(own, box)) > _OWN or {shape.tag for shape in one.felt} != {"mesh"}:
        return
    others = [(other.name, shared(seen, box)) for other in context.view.links if (seen := visual(other)) is not None]
    name, best = max(others, key=lambda each: each[1])
    if best >= _OTHER:
        what = f"its collision shape is that of link '{name}': their boxes share {best:.0%}"
        yield Misfit(one.felt[0], f"{what}, with its own visual {fit:.0%}", "name the mesh of this link", fit, _OWN)


def _aside(one: _Link) -> Iterator[Misfit]:
    """A shape that is seen, too, at another place."""
    seen, felt = ([each for each in shapes if each in one.known] for shapes in (one.seen, one.felt))
    if not seen:
        return
    places = np.array([(box.lo, box.hi) for box in (one.known[each].placed(STILL) for each in seen)])
    of_seen, of_felt = (
        (np.array([each.tag for each in shapes]), np.array([_sides(each, one.known) for each in shapes]).reshape(-1, 3))
        for shapes in (seen, felt)
    )
    for k, shape in enumerate(felt):
        twins = np.flatnonzero(_same(k, of_felt, of_seen))
        if not 0 < np.count_nonzero(_same(k, of_felt, of_felt)) <= len(twins):
            continue
        box = one.known[shape].placed(STILL)
        away = float(np.linalg.norm(places[twins] - (box.lo, box.hi), axis=2).max(axis=1).min())
        if away > max(_ASIDE * size_of(box), _LEAST):
            what = f"its collision {shape.tag} is not where its visual is, but up to {away:.3g} m from there"
            yield Misfit(shape, what, "give both the same <origin>", away, _ASIDE * size_of(box))


def _scaled(one: _Link) -> Iterator[Misfit]:
    """A mesh of another size than the same mesh, or the link's only one, that is seen."""
    seen = [shape for shape in one.seen if shape.tag == "mesh"]
    for shape in (shape for shape in one.felt if shape.tag == "mesh" and shape in one.known):
        twins = [other for other in seen if other.uri == shape.uri] or (seen if len(one.felt) == 1 else [])
        if len(twins) != 1 or twins[0] not in one.known:
            continue
        sides, own = (_sides(each, one.known) for each in (shape, twins[0]))
        if not (sides > 0).all() or not (own > 0).all():
            continue
        ratios = sides / own
        factor = float(ratios.prod()) ** (1 / 3)
        if max(factor, 1 / factor) >= _SCALED and ratios.max() <= _EVEN * ratios.min():
            what = f"its collision mesh is {factor:.3g} times as large as its visual, in all three axes"
            yield Misfit(shape, what, "give both the same scale", factor, 1.0)


def _enormous(one: _Link, context: Context) -> Iterator[Misfit]:
    """A primitive that is far larger than what is seen."""
    seen = reach(context) if one.seen_box is None else size_of(one.seen_box)
    for shape in one.felt if seen >= _SEEN else ():
        ratio = size_of(one.known[shape].box) / seen if shape in one.known and shape.tag != "mesh" else 0.0
        if ratio > _LARGE:
            than = "the robot's longest offset between joints" if one.seen_box is None else "what is seen of the link"
            what = f"its collision {shape.tag} is {ratio:.3g} times as large as {than}"
            cause = "its numbers are in millimetres" if ratio / 1e3 < 2 * _BETTER and ratio > 100 else None
            yield Misfit(shape, what, "write its size in metres", ratio, _LARGE, cause)


def _exchanged(one: _Link) -> Iterator[Misfit]:
    """A cylinder that fits by exchanging its radius and length."""
    if one.seen_box is None or one.felt_box is None:
        return
    as_is = shared(one.seen_box, one.felt_box)
    for shape in (shape for shape in one.felt if shape.tag == "cylinder"):
        x, _, z = one.known[shape].box.hi
        half = np.array((2 * z, 2 * z, x / 2))
        exchanged = Solid(Box(-half, half), one.known[shape].pose)
        boxes = [(exchanged if each is shape else one.known[each]).placed(STILL) for each in one.felt]
        fit = shared(one.seen_box, around(boxes))
        if fit >= max(_FITTING, (_BETTER if fit >= 2 * _FITTING else _MUCH_BETTER) * as_is):
            what = "its collision cylinder fits what is seen with radius and length exchanged: their boxes then share "
            what += f"{fit:.0%}, as it stands {as_is:.0%}"
            assert shape.shape is not None, "it is a cylinder"
            remedy = f'write radius="{shape.shape.get("length")}" length="{shape.shape.get("radius")}"'
            yield Misfit(shape, what, remedy, as_is, fit, "radius and length are exchanged")


def _away(one: _Link) -> Iterator[Misfit]:
    """A shape that has a wide gap to all that is seen."""
    own = one.seen_box
    if own is None:
        return
    for shape in (shape for shape in one.felt if shape in one.known):
        box = one.known[shape].placed(STILL)
        between, bound = gap(own, box), max(_APART * max(size_of(own), size_of(box)), _LEAST)
        if between > bound:
            what = f"there are {between:.3g} m between its collision {shape.tag} and its visual"
            yield Misfit(shape, what, "check the <origin> of both", between, bound)


def _unlike(one: _Link) -> Iterator[Misfit]:
    """A collision mesh that is hardly where the visual one is: it is turned, or one of them is another part's."""
    if one.seen_box is None or one.felt_box is None or [shape.tag for shape in (*one.felt, *one.seen)] != ["mesh"] * 2:
        return
    fit = shared(one.seen_box, one.felt_box)
    if fit <= _UNLIKE:
        what = f"its collision mesh is not the part that its visual is: their boxes share {fit:.0%}"
        remedy = "check the <origin> of both, and that neither is the mesh of another link"
        yield Misfit(one.felt[0], what, remedy, fit, _UNLIKE)


def shared(first: Box, second: Box) -> float:
    """The volume that two boxes share over that of both together."""
    sides = np.minimum(first.hi, second.hi) - np.maximum(first.lo, second.lo)
    if (sides <= 0).any():
        return 0.0
    both = float(sides.prod())
    return both / (float((first.hi - first.lo).prod()) + float((second.hi - second.lo).prod()) - both)


def _sides(shape: GeometryView, known: Solids) -> Floats:
    """(3,) the sides of its box in its own axes, ascending [m]."""
    return np.sort(known[shape].box.hi - known[shape].box.lo)


def _same(k: int, among: tuple[NDArray[np.str_], Floats], others: tuple[NDArray[np.str_], Floats]) -> NDArray[np.bool_]:
    """(n,) which others are of the kind and size of shape k; meshes may be simplified."""
    (kinds, sides), (others_kinds, others_sides) = among, others
    slack = _ALIKE if kinds[k] == "mesh" else 1e-2
    near = np.abs(others_sides - sides[k]) <= slack * np.maximum(others_sides, sides[k])
    found: NDArray[np.bool_] = (others_kinds == kinds[k]) & near.all(axis=1)
    return found
